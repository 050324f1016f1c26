//! Screens: which direction belongs to which place of the picture.
//!
//! Axes of the view: x right, y up, z forward. `x`, `y`: pixels right of and above the picture's centre;
//! `w`, `h`: the picture's size in pixels. Angles of the mappings:
//!
//! ```text
//! planar           (x, y, f)                                    f = w / (2 tan(hfov/2))
//! lens             (u, v, f), which is seen at (x, y)           see [`super::distortion`]
//! cylindrical      azimuth α = x·s, (sin α, y·s, cos α)         s = hfov/w; upright lines stay upright
//! equirectangular  azimuth α = x·hfov/w, elevation ε = y·vfov/h
//! fisheye          angle from the axis θ = r·fov/d, r = |(x, y)| ≤ d/2, d = min(w, h)   (equidistant)
//! table            what the table says, between its entries bilinear
//! orthographic     (0, 0, 1) from the point (x, y)·width/w beside the eye
//! ```
//!
//! After Hughes patent, "non-planar screens": the screen point of each pixel from a table, rotated with the
//! eye; the closed forms are tables that need no memory. Projections: Snyder, *Map Projections: A Working
//! Manual* (1987), equidistant cylindrical and azimuthal equidistant; Greene, *Environment Mapping and Other
//! Applications of World Projections* (1986), fisheye.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::RayTable;
use super::distortion::{seen, undistorted};
use hedgehop_base::error::{Error, Result};

/// Surface that a picture is projected on.
#[derive(Debug, Clone, PartialEq)]
pub enum Screen {
    /// A plane; square pixels.
    Planar {
        /// Horizontal field of view, degrees, 0 < hfov < 180.
        hfov: f64,
    },
    /// A plane seen through a lens with radial distortion (Brown and Conrady): a point at the distance r from the middle of a planar picture, in units of its
    /// focal length, is seen at r·(1 + k₁r² + k₂r⁴). Beyond where that folds there is no picture.
    Lens {
        /// Horizontal field of view of the planar picture, degrees, 0 < hfov < 180: the middle has its scale. With k₁ < 0 (a barrel) the lens sees more, with k₁ > 0
        /// (a pincushion) less.
        hfov: f64,
        /// k₁ and k₂.
        k: [f64; 2],
    },
    /// An upright cylinder around the eye: azimuth grows evenly along a row; pixels are square where the
    /// cylinder is nearest, so that the height of the picture decides how far up and down it sees, less than
    /// 90° each.
    Cylindrical {
        /// Horizontal field of view, degrees, 0 < hfov ≤ 360.
        hfov: f64,
    },
    /// Azimuth along the rows, elevation along the columns, both even.
    Equirectangular {
        /// Azimuths in the picture, degrees, 0 < hfov ≤ 360.
        hfov: f64,
        /// Elevations in the picture, degrees, 0 < vfov ≤ 180, as many above as below the middle.
        vfov: f64,
    },
    /// A dome: the angle from the optical axis grows evenly with the distance from the picture's centre. The
    /// circle of `fov` touches the longer sides' middles; outside of it there is no picture.
    Fisheye {
        /// Angle across the circle, degrees, 0 < fov ≤ 360.
        fov: f64,
    },
    /// A direction for every pixel, from a table. A table of another size is stretched over the picture.
    Table(Arc<RayTable>),
    /// Parallel rays along the optical axis, square pixels: the God's-eye view when it looks straight down.
    Orthographic {
        /// Ground that the picture's width covers, metres, > 0.
        width: f64,
    },
}

/// Width of a pixel where its ray ends, across the ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Footprint {
    /// Width that grows with range: the angle between neighbouring pixels, radians.
    Angle(f64),
    /// The same at any range, metres.
    Width(f64),
}

impl Footprint {
    /// Metres at `range` metres.
    pub fn at(self, range: f64) -> f64 {
        match self {
            Self::Angle(angle) => range * angle,
            Self::Width(width) => width,
        }
    }
}

/// A screen of so many pixels: what [`Screen`] maps.
#[derive(Debug, Clone)]
pub(super) struct Mapping {
    pub screen: Screen,
    /// Columns and rows.
    size: DVec2,
    /// Pixels per radian at the picture's centre; planar: distance of the screen in pixels; orthographic: pixels
    /// per metre.
    pub scale: f64,
    /// Azimuth of the picture's centre against the axes of the view, pixels.
    shift: f64,
}

impl Screen {
    /// Returns the name that users call it by.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Planar { .. } => "planar",
            Self::Lens { .. } => "lens",
            Self::Cylindrical { .. } => "cylindrical",
            Self::Equirectangular { .. } => "equirectangular",
            Self::Fisheye { .. } => "fisheye",
            Self::Table(_) => "table",
            Self::Orthographic { .. } => "orthographic",
        }
    }

    /// Refuses angles and widths outside the ranges that the variants state.
    pub fn check(&self) -> Result<()> {
        let angle = |flag: &str, angle: f64, most: f64| {
            if angle > 0.0 && angle <= most {
                return Ok(());
            }
            let name = self.name();
            Err(Error::Configuration(format!(
                "the field of view ({flag}) of a {name} screen must be more than 0° and at most {most}°, not {angle}°"
            )))
        };

        match *self {
            Self::Lens { k, .. } if !k.into_iter().all(f64::is_finite) => Err(Error::Configuration(
                "a lens has finite coefficients of distortion (--distortion)".into(),
            )),
            Self::Planar { hfov } | Self::Lens { hfov, .. } if hfov > 0.0 && hfov < 180.0 => Ok(()),
            Self::Planar { hfov } | Self::Lens { hfov, .. } => Err(Error::Configuration(format!(
                "the field of view (--hfov) of a planar screen must lie between 0 and 180°, not {hfov}°; a cylindrical screen sees more"
            ))),
            Self::Cylindrical { hfov } => angle("--hfov", hfov, 360.0),
            Self::Equirectangular { hfov, vfov } => {
                angle("--hfov", hfov, 360.0).and_then(|()| angle("--vfov", vfov, 180.0))
            }
            Self::Fisheye { fov } => angle("--hfov", fov, 360.0),
            Self::Table(_) => Ok(()),
            Self::Orthographic { width } if width > 0.0 && width.is_finite() => Ok(()),
            Self::Orthographic { width } => Err(Error::Configuration(format!(
                "the width (--ground-width) of an orthographic view must be more than 0 m, not {width} m"
            ))),
        }
    }

    /// Angle that a row through the picture's centre sees (a fisheye: that its circle sees), degrees; `None` where a table
    /// or parallel rays have no such angle.
    pub fn hfov(&self) -> Option<f64> {
        match *self {
            Self::Planar { hfov }
            | Self::Lens { hfov, .. }
            | Self::Cylindrical { hfov }
            | Self::Equirectangular { hfov, .. } => Some(hfov),
            Self::Fisheye { fov } => Some(fov),
            Self::Table(_) | Self::Orthographic { .. } => None,
        }
    }

    /// Whether neighbouring columns differ by an azimuth, so that turning the view to the side shifts the
    /// picture.
    pub(super) fn turns_by_columns(&self) -> bool {
        matches!(self, Self::Cylindrical { .. } | Self::Equirectangular { .. })
    }
}

/// Name and everything that decides the rays, as `name key=value`; numbers read back to the same f64.
impl std::fmt::Display for Screen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = self.name();
        match self {
            Self::Planar { hfov } | Self::Cylindrical { hfov } => write!(f, "{name} hfov_deg={hfov}"),
            Self::Lens { hfov, k: [k1, k2] } => write!(f, "{name} hfov_deg={hfov} k1={k1} k2={k2}"),
            Self::Equirectangular { hfov, vfov } => write!(f, "{name} hfov_deg={hfov} vfov_deg={vfov}"),
            Self::Fisheye { fov } => write!(f, "{name} fov_deg={fov}"),
            Self::Table(table) => write!(f, "{name} blake3={}", table.digest()),
            Self::Orthographic { width } => write!(f, "{name} width_m={width}"),
        }
    }
}

impl Mapping {
    /// `screen` of `width` × `height` pixels. `yaw` (degrees) shifts the picture of a screen that
    /// [`Screen::turns_by_columns`]; it is nothing to others.
    pub fn new(screen: Screen, width: u32, height: u32, yaw: f64) -> Self {
        let size = DVec2::new(f64::from(width), f64::from(height));
        let per_degree = |fov: f64, side: f64| 1.0 / (fov / side).to_radians();
        let scale = match screen {
            Screen::Planar { hfov } | Screen::Lens { hfov, .. } => {
                0.5 * size.x / (0.5 * hfov.to_radians()).tan()
            }
            Screen::Cylindrical { hfov } => per_degree(hfov, size.x),
            // The wider side of a pixel counts, so that nothing is finer than the picture can show.
            Screen::Equirectangular { hfov, vfov } => per_degree(hfov, size.x).min(per_degree(vfov, size.y)),
            Screen::Fisheye { fov } => per_degree(fov, size.min_element()),
            Screen::Table(ref table) => (size / table.size().as_dvec2()).min_element() / table.pixel_angle(),
            Screen::Orthographic { width } => size.x / width,
        };

        // Whole pixels stay whole: channels that share an edge then share their rays to the last bit.
        let shift = match screen {
            Screen::Cylindrical { hfov } | Screen::Equirectangular { hfov, .. } => yaw * size.x / hfov,
            _ => 0.0,
        };

        Self { screen, size, scale, shift }
    }

    /// The same screen with `times` as many pixels along each side.
    pub fn enlarged(&self, times: u32) -> Self {
        let size = self.size * f64::from(times);
        let larger = Self::new(self.screen.clone(), size.x as u32, size.y as u32, 0.0);
        Self { shift: self.shift * f64::from(times), ..larger }
    }

    /// Whether both map alike.
    pub fn is_like(&self, other: &Self) -> bool {
        let same = match (&self.screen, &other.screen) {
            // Comparing large tables themselves would take a part of each frame.
            (Screen::Table(own), Screen::Table(other)) => own.digest() == other.digest(),
            (own, other) => own == other,
        };
        same && (self.size, self.shift) == (other.size, other.shift)
    }

    /// Returns how wide pixels are, at the widest.
    pub fn footprint(&self) -> Footprint {
        match self.screen {
            Screen::Orthographic { .. } => Footprint::Width(1.0 / self.scale),
            _ => Footprint::Angle(1.0 / self.scale),
        }
    }

    /// Radians of azimuth to the right of the view's axis.
    fn azimuth(&self, x: f64, hfov: f64) -> f64 {
        ((x + self.shift) * (hfov / self.size.x)).to_radians()
    }

    /// Origin (metres from the eye) and direction (of any length but 0), in the axes of the view, of the ray through a
    /// screen position; `None` where there is none.
    pub fn ray(&self, column: f64, row: f64) -> Option<(DVec3, DVec3)> {
        let (x, y) = (column - 0.5 * self.size.x, 0.5 * self.size.y - row);
        let direction = match self.screen {
            Screen::Planar { .. } => DVec3::new(x, y, self.scale),
            Screen::Lens { k, .. } => undistorted(k, DVec2::new(x, y) / self.scale)?.extend(1.0),
            Screen::Cylindrical { hfov } => {
                let (sine, cosine) = self.azimuth(x, hfov).sin_cos();
                DVec3::new(sine, y / self.scale, cosine)
            }
            Screen::Equirectangular { hfov, vfov } => {
                let elevation = y / self.size.y * vfov;
                if elevation.abs() > 90.0 {
                    return None;
                }
                let (sine, cosine) = self.azimuth(x, hfov).sin_cos();
                let (up, level) = elevation.to_radians().sin_cos();
                DVec3::new(sine * level, up, cosine * level)
            }
            Screen::Fisheye { .. } => {
                let radius = x.hypot(y);
                if radius > 0.5 * self.size.min_element() {
                    return None;
                }
                if radius == 0.0 {
                    return Some((DVec3::ZERO, DVec3::Z));
                }
                let (across, along) = (radius / self.scale).sin_cos();
                DVec3::new(x * across / radius, y * across / radius, along)
            }
            Screen::Table(ref table) => {
                let stretch = table.size().as_dvec2() / self.size;
                table.direction(column * stretch.x, row * stretch.y)?
            }
            Screen::Orthographic { .. } => {
                return Some((DVec3::new(x / self.scale, y / self.scale, 0.0), DVec3::Z));
            }
        };

        Some((DVec3::ZERO, direction))
    }

    /// Screen position of a point in the axes of the view, metres from the eye; `None` where no ray meets it, and for
    /// tables, which have no inverse.
    pub fn position(&self, point: DVec3) -> Option<DVec2> {
        let azimuth_px = |hfov: f64| {
            let turn = 360.0 * self.size.x / hfov;
            let ahead = point.x.atan2(point.z).to_degrees() * self.size.x / hfov - self.shift;
            // The turn of the cylinder that lies nearest to the picture's centre.
            ahead - turn * (ahead / turn).round()
        };
        let level = point.x.hypot(point.z);

        let offset = match self.screen {
            Screen::Planar { .. } if point.z > 0.0 => point.truncate() / point.z * self.scale,
            Screen::Lens { k, .. } if point.z > 0.0 => seen(k, point.truncate() / point.z)? * self.scale,
            Screen::Cylindrical { hfov } if level > 0.0 => {
                DVec2::new(azimuth_px(hfov), point.y / level * self.scale)
            }
            Screen::Equirectangular { hfov, vfov } if level > 0.0 || point.y != 0.0 => {
                DVec2::new(azimuth_px(hfov), point.y.atan2(level).to_degrees() * self.size.y / vfov)
            }
            Screen::Fisheye { fov } => {
                let across = point.truncate();
                let angle = across.length().atan2(point.z);
                if angle > 0.5 * fov.to_radians() || point == DVec3::ZERO {
                    return None;
                }
                across.normalize_or_zero() * (angle * self.scale)
            }
            Screen::Orthographic { .. } if point.z >= 0.0 => point.truncate() * self.scale,
            _ => return None,
        };

        Some(DVec2::new(0.5 * self.size.x + offset.x, 0.5 * self.size.y - offset.y))
    }
}
