//! Cuts of a flight into runs of frames that cost about the same.

use std::ops::Range;

/// Cuts frames of these costs into at most `count` runs, none empty, so that each costs about as much as the others.
///
/// The k-th cut lies where the sum comes closest to k / `count` of all: no run costs more than its share by more than
/// one frame.
pub fn cut(costs: &[f64], count: usize) -> Vec<Range<usize>> {
    let count = count.clamp(1, costs.len().max(1));
    let share = costs.iter().sum::<f64>() / count as f64;
    let mut runs: Vec<Range<usize>> = Vec::with_capacity(count);
    let (mut begin, mut sum) = (0, 0.0);

    for (index, cost) in costs.iter().enumerate() {
        let target = share * (runs.len() + 1) as f64;
        // A frame belongs behind the cut if its middle does.
        if index > begin && runs.len() + 1 < count && sum + 0.5 * cost > target {
            runs.push(begin..index);
            begin = index;
        }
        sum += cost;
    }
    if begin < costs.len() {
        runs.push(begin..costs.len());
    }

    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn longest_over_mean(costs: &[f64], runs: &[Range<usize>]) -> f64 {
        let sums: Vec<f64> = runs.iter().map(|run| costs[run.clone()].iter().sum()).collect();
        sums.iter().copied().fold(0.0, f64::max) * sums.len() as f64 / sums.iter().sum::<f64>()
    }

    #[test]
    fn every_frame_is_in_one_run() {
        for (frames, count) in [(0, 3), (1, 1), (1, 9), (7, 3), (100, 7), (100, 100), (5, 0)] {
            let costs: Vec<f64> = (0..frames).map(|frame| 1.0 + f64::from(frame * 7919 % 13)).collect();
            let runs = cut(&costs, count);
            let all: Vec<usize> = runs.iter().cloned().flatten().collect();
            assert_eq!(all, (0..costs.len()).collect::<Vec<_>>(), "{frames} in {count}");
            assert!(runs.iter().all(|run| !run.is_empty()) && runs.len() <= count.max(1));
        }
    }

    #[test]
    fn runs_cost_the_same_where_counts_do_not() {
        // A flight that comes down: the last fifth of its frames costs five times as much.
        let costs: Vec<f64> = (0..1000).map(|frame| if frame < 800 { 1.0 } else { 5.0 }).collect();
        let by_count: Vec<_> = (0..10).map(|run| run * 100..(run + 1) * 100).collect();
        assert!(longest_over_mean(&costs, &by_count) > 2.5);
        let runs = cut(&costs, 10);
        assert_eq!(runs.len(), 10);
        assert!(longest_over_mean(&costs, &runs) < 1.03);
    }

    #[test]
    fn equal_frames_are_cut_evenly() {
        let lengths: Vec<usize> = cut(&[0.25; 12], 4).into_iter().map(|run| run.len()).collect();
        assert_eq!(lengths, [3, 3, 3, 3]);
    }
}
