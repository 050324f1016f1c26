//! Prediction of how long frames take: a + b · rays + c · pages and so on, fitted to a few that were rendered.

use serde::{Deserialize, Serialize};

/// Load of a frame, as known before it is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameLoad {
    /// Rays that may meet ground, millions.
    pub mrays: f64,
    /// Pages that may be in sight.
    pub pages: f64,
    /// Objects of the scene that stand in front of it.
    pub bodies: f64,
    /// Pages that must be in memory before it begins, MiB.
    pub mib: f64,
    /// Pages of these that no frame before it needs, MiB.
    pub new_mib: f64,
}

impl FrameLoad {
    /// Returns the loads that a frame costs by whether or not the frame before it was rendered, with 1 for what all frames cost.
    fn terms(&self) -> [f64; TERMS] {
        [1.0, self.mrays, self.pages, self.bodies]
    }
}

/// Terms of the sum.
const TERMS: usize = 4;
/// Rounds of the fit; each lowers the error, and the last ones by nothing that is seen.
const ROUNDS: usize = 4000;

/// Frames that were rendered in a row to see what they cost, in a process of their own.
#[derive(Debug, Clone, PartialEq)]
pub struct CostSample {
    /// Index of the first frame among all of the job.
    pub index: usize,
    /// Time before the first frame: the database is opened, the path bound; seconds.
    pub start_s: f64,
    /// Time of the first frame, for which all pages come into memory, seconds.
    pub first_s: f64,
    /// Time of a frame behind it, seconds.
    pub frame_s: f64,
}

/// Model of what frames cost, in seconds of a process with so many workers as the samples had.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CostModel {
    /// A process, before its first frame.
    pub start_s: f64,
    /// Every frame.
    pub frame_s: f64,
    /// A million rays that may meet ground.
    pub mray_s: f64,
    /// A page in sight.
    pub page_s: f64,
    /// An object of the scene.
    pub body_s: f64,
    /// A MiB of pages that come into memory.
    pub mib_s: f64,
    /// Samples, and what the model says of each if it is fitted without it.
    pub samples: Vec<SampledFrame>,
}

/// A sample, and how well it was predicted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SampledFrame {
    /// Number of the frame.
    pub frame: u64,
    /// Measured time, seconds.
    pub measured_s: f64,
    /// Time that a model of the other samples predicts, seconds; of fewer than three samples, that of all.
    pub predicted_s: f64,
}

/// Times of the frames of a job, as predicted.
#[derive(Debug, Clone, PartialEq)]
pub struct CostPrediction {
    /// The model behind it.
    pub model: CostModel,
    /// Each frame behind another, seconds.
    pub frames: Vec<f64>,
}

impl CostPrediction {
    /// Fits a model to `samples` and predicts frames of these numbers and loads.
    ///
    /// Between samples, what the model leaves over goes over from the one to the other: light, weather and whatever else
    /// has no term of its own changes slowly along a flight.
    pub fn fit(numbers: &[u64], loads: &[FrameLoad], samples: &[CostSample]) -> Self {
        let mut model = fit_terms(loads, samples);
        let mean = |of: &dyn Fn(&CostSample) -> f64| {
            samples.iter().map(of).sum::<f64>() / samples.len().max(1) as f64
        };
        model.start_s = mean(&|sample| sample.start_s);

        // The first frame of a process has all its pages to wait for.
        let mib = |sample: &CostSample| loads[sample.index].mib;
        let extra = mean(&|sample| (sample.first_s - sample.frame_s).max(0.0) * mib(sample));
        let square = mean(&|sample| mib(sample).powi(2));
        model.mib_s = if square > 0.0 { extra / square } else { 0.0 };
        model.samples = samples
            .iter()
            .enumerate()
            .map(|(place, sample)| {
                let mut others = samples.to_vec();
                if others.len() > 2 {
                    others.remove(place);
                }
                let others_model = fit_terms(loads, &others);
                SampledFrame {
                    frame: numbers[sample.index],
                    measured_s: sample.frame_s,
                    predicted_s: others_model.corrected(loads, &others, sample.index),
                }
            })
            .collect();

        let frames = (0..loads.len())
            .map(|index| model.corrected(loads, samples, index) + model.mib_s * loads[index].new_mib)
            .collect();
        Self { model, frames }
    }

    /// Predicts that all frames cost the same.
    pub fn equal(count: usize) -> Self {
        Self { model: CostModel { frame_s: 1.0, ..CostModel::default() }, frames: vec![1.0; count] }
    }

    /// Returns the time of a process that renders the frames of `run`, seconds.
    pub fn run_s(&self, loads: &[FrameLoad], run: std::ops::Range<usize>) -> f64 {
        let first = loads.get(run.start).map_or(0.0, |load| load.mib - load.new_mib);
        self.model.start_s + self.model.mib_s * first + self.frames[run].iter().sum::<f64>()
    }
}

impl CostModel {
    fn of_load(&self, load: &FrameLoad) -> f64 {
        let weights = [self.frame_s, self.mray_s, self.page_s, self.body_s];
        load.terms().iter().zip(weights).map(|(term, weight)| term * weight).sum()
    }

    /// Returns the time of a frame, with what the samples about it leave over.
    fn corrected(&self, loads: &[FrameLoad], samples: &[CostSample], index: usize) -> f64 {
        let ratio = |sample: &CostSample| sample.frame_s / self.of_load(&loads[sample.index]).max(1e-9);
        let behind = samples.partition_point(|sample| sample.index <= index);
        let ratio = match (behind.checked_sub(1).map(|at| &samples[at]), samples.get(behind)) {
            (Some(before), Some(after)) => {
                let way = (index - before.index) as f64 / (after.index - before.index) as f64;
                ratio(before) * (1.0 - way) + ratio(after) * way
            }
            (Some(only), None) | (None, Some(only)) => ratio(only),
            (None, None) => 1.0,
        };
        self.of_load(&loads[index]) * ratio
    }

    /// Share by which samples were predicted wrongly, of the time measured: the middle one, and the worst; `None` of fewer
    /// than three, which no others predict.
    pub fn errors(&self) -> Option<(f64, f64)> {
        let of = |sample: &SampledFrame| (sample.predicted_s / sample.measured_s.max(1e-9) - 1.0).abs();
        let mut errors: Vec<f64> = self.samples.iter().map(of).collect();
        errors.sort_by(f64::total_cmp);
        let most = errors.last().filter(|_| errors.len() > 2)?;
        Some((errors[errors.len() / 2], *most))
    }

    /// Says how well samples were predicted, behind a sentence.
    pub fn errors_told(&self) -> String {
        self.errors().map_or_else(String::new, |(median, most)| {
            let [median, most] = [median, most].map(|share| 100.0 * share);
            format!("; samples were predicted within {median:.0} %, the worst within {most:.0} %")
        })
    }
}

/// Returns the frame that is worth a sample next to these, which rise by their index; `None` if all frames are known.
///
/// Between two samples two predictions are at hand: the model's, and the straight line from one time to the other. Where they, or the two times,
/// differ most, over most frames, least is known.
pub fn least_known(loads: &[FrameLoad], samples: &[CostSample]) -> Option<usize> {
    let model = fit_terms(loads, samples);
    let mut bounds = vec![None];
    bounds.extend(samples.iter().map(Some));
    bounds.push(None);

    let mut worst: Option<(f64, usize)> = None;
    for pair in bounds.windows(2) {
        let begin = pair[0].map_or(0, |sample| sample.index + 1);
        let end = pair[1].map_or(loads.len(), |sample| sample.index);
        let (Some(before), Some(after)) = (pair[0].or(pair[1]), pair[1].or(pair[0])) else { continue };
        let step = (after.frame_s - before.frame_s).abs();
        let doubt = |index: usize| {
            let way = (index + 1 - begin) as f64 / (end + 1 - begin) as f64;
            let line = before.frame_s * (1.0 - way) + after.frame_s * way;
            // Beside a sample nothing new is seen, and a flight that is equal everywhere is halved.
            let room = 4.0 * way * (1.0 - way);
            let differ = (model.corrected(loads, samples, index) - line).abs() + 0.25 * step;
            room * (differ + 0.01 * line)
        };

        let sum: f64 = (begin..end).map(doubt).sum();
        let place = (begin..end).max_by(|a, b| doubt(*a).total_cmp(&doubt(*b)));
        if let Some(place) = place.filter(|_| worst.is_none_or(|(most, _)| sum > most)) {
            worst = Some((sum, place));
        }
    }
    worst.map(|(_, place)| place)
}

/// Fits the terms of frames to samples: no weight below zero, and the least sum of squares of relative errors, by
/// coordinate descent (Franc, Hlaváč and Navara 2005).
fn fit_terms(loads: &[FrameLoad], samples: &[CostSample]) -> CostModel {
    let rows: Vec<[f64; TERMS]> = samples
        .iter()
        .map(|sample| loads[sample.index].terms().map(|term| term / sample.frame_s.max(1e-9)))
        .collect();
    let mut weights = [0.0; TERMS];

    for _ in 0..ROUNDS {
        for term in 0..TERMS {
            let square: f64 = rows.iter().map(|row| row[term].powi(2)).sum();
            if square == 0.0 {
                continue;
            }
            let rest = |row: &[f64; TERMS]| {
                1.0 - row.iter().zip(weights).map(|(load, weight)| load * weight).sum::<f64>()
            };
            let step: f64 = rows.iter().map(|row| row[term] * rest(row)).sum::<f64>() / square;
            weights[term] = f64::max(weights[term] + step, 0.0);
        }
    }

    let [frame_s, mray_s, page_s, body_s] = weights;
    CostModel { frame_s, mray_s, page_s, body_s, ..CostModel::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flight over pages that come and go, every frame of which takes what a model says.
    fn flight(cost: impl Fn(usize, &FrameLoad) -> f64) -> (Vec<FrameLoad>, Vec<CostSample>, Vec<f64>) {
        let load = |frame: usize| FrameLoad {
            mrays: 1.0 + (frame as f64 / 70.0).sin(),
            pages: 20.0 + 15.0 * (frame as f64 / 31.0).cos(),
            mib: 8.0,
            new_mib: 0.1,
            ..FrameLoad::default()
        };
        let loads: Vec<_> = (0..500).map(load).collect();
        let costs: Vec<f64> = (0..).zip(&loads).map(|(frame, load)| cost(frame, load)).collect();
        let sample = |index: usize| CostSample {
            index,
            start_s: 0.5,
            first_s: costs[index] + 0.8,
            frame_s: costs[index],
        };
        let samples = (0..8).map(|place| sample(31 + 62 * place)).collect();
        (loads, samples, costs)
    }

    #[test]
    fn a_cost_that_is_a_sum_of_the_terms_is_found() {
        let (loads, samples, costs) = flight(|_, load| 0.01 + 0.02 * load.mrays + 0.001 * load.pages);
        let numbers: Vec<u64> = (1..=500).collect();
        let found = CostPrediction::fit(&numbers, &loads, &samples);
        let (median, most) = found.model.errors().unwrap();
        assert!(median < 1e-3 && most < 0.01, "{median} {most}: {:?}", found.model);
        assert!((found.model.mib_s - 0.1).abs() < 1e-9 && found.model.start_s == 0.5);
        for (cost, told) in costs.iter().zip(&found.frames) {
            assert!((told - 0.01 - cost).abs() < 0.01 * cost, "{told} for {cost} and 0.1 MiB of new pages");
        }
        let run_s = found.run_s(&loads, 0..500);
        let expected = 0.5 + costs.iter().sum::<f64>() + 0.01 * 500.0 + 0.1 * 7.9;
        assert!((run_s / expected - 1.0).abs() < 0.01, "{run_s} {expected}");
    }

    #[test]
    fn what_has_no_term_is_taken_from_the_samples_about() {
        let village = |frame: usize| if frame > 250 { 3.0 } else { 1.0 };
        let (loads, samples, costs) = flight(|frame, _| 0.02 * village(frame));
        let found = CostPrediction::fit(&(1..=500).collect::<Vec<_>>(), &loads, &samples);
        for frame in [100, 150, 400, 480] {
            let told = found.frames[frame] - 0.01;
            assert!((told / costs[frame] - 1.0).abs() < 0.05, "{frame}: {told} {}", costs[frame]);
        }
    }

    #[test]
    fn samples_gather_where_least_is_known() {
        // Frames 120 to 139 cost ten times as much, which no term tells.
        let cost = |index: usize| if (120..140).contains(&index) { 1.0 } else { 0.1 };
        let loads = vec![FrameLoad { mrays: 1.0, ..FrameLoad::default() }; 400];
        let sample = |index: usize| {
            let frame_s = cost(index);
            CostSample { index, start_s: 0.0, first_s: frame_s, frame_s }
        };
        let mut samples: Vec<_> = [50, 130, 250, 350].map(sample).to_vec();
        for _ in 0..8 {
            let index = least_known(&loads, &samples).unwrap();
            samples.push(sample(index));
            samples.sort_by_key(|sample| sample.index);
        }
        assert!(
            samples.iter().filter(|sample| (90..170).contains(&sample.index)).count() >= 5,
            "{samples:?}"
        );

        let one = [sample(0)];
        assert_eq!(least_known(&loads[..1], &one), None);
        assert!(least_known(&loads[..3], &one).is_some());
    }

    #[test]
    fn one_sample_or_none_is_enough_to_go_on() {
        let (loads, samples, _) = flight(|_, _| 0.25);
        let numbers: Vec<u64> = (1..=500).collect();
        let found = CostPrediction::fit(&numbers, &loads, &samples[..1]);
        assert!(found.frames.iter().all(|told| told.is_finite() && *told > 0.0));
        assert!(CostPrediction::fit(&numbers, &loads, &[]).model.errors().is_none());
        assert_eq!(CostPrediction::equal(3).frames, [1.0; 3]);
    }
}
