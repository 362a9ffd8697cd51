//! A slice through a volume: grey values as bytes, and the line where they cross a threshold.

use asphera_report::{Refusal, SliceRequest, VOLUME_SLICE_FORMAT, VolumeSlice};

use crate::body::Scan;

/// A plane of samples, every `step`-th of them.
struct Plane<'a> {
    scan: &'a Scan,
    request: SliceRequest,
    /// Pixels along the columns and the rows.
    pixels: [usize; 2],
    step: usize,
}

impl Scan {
    /// The slice without points of faces. Grey values from `shown_range` become the bytes 1 to 255.
    ///
    /// # Errors
    ///
    /// Where there is no slice of that number.
    pub(crate) fn slice(
        &self,
        request: SliceRequest,
        shown_range: [f64; 2],
        threshold: f64,
    ) -> Result<VolumeSlice, Refusal> {
        let across = self.size[request.axis.index()];
        if request.index >= across as u64 {
            return Err(Refusal(format!(
                "no slice {} across {}: expected 0 to {}",
                request.index,
                request.axis.name(),
                across - 1
            )));
        }
        let plane = Plane::new(self, request);
        let (contour, contour_left_out) = plane.contour(threshold);
        let [columns, rows] = plane.pixels;
        Ok(VolumeSlice {
            format: VOLUME_SLICE_FORMAT,
            axis: request.axis,
            index: request.index,
            columns: columns as u64,
            rows: rows as u64,
            step: plane.step as u64,
            pixels: plane.bytes(shown_range),
            contour,
            contour_left_out,
            points: Vec::new(),
            points_left_out: 0,
        })
    }
}

impl Plane<'_> {
    fn new(scan: &Scan, request: SliceRequest) -> Plane<'_> {
        let samples = request.axis.within().map(|axis| scan.size[axis]);
        let step = samples[0].max(samples[1]).div_ceil(MOST_PIXELS).max(1);
        Plane { scan, request, pixels: samples.map(|side| side.div_ceil(step)), step }
    }

    /// The grey value of a pixel.
    fn at(&self, column: usize, row: usize) -> f64 {
        let [along, down] = self.request.axis.within();
        let mut place = [self.request.index as usize; 3];
        place[along] = column * self.step;
        place[down] = row * self.step;
        let [nx, ny, _] = self.scan.size;
        f64::from(self.scan.values[(place[2] * ny + place[1]) * nx + place[0]])
    }

    fn bytes(&self, [black, white]: [f64; 2]) -> Vec<u8> {
        let [columns, rows] = self.pixels;
        let scale = if white > black { 254.0 / (white - black) } else { 0.0 };
        let byte = |value: f64| match value.is_finite() {
            true => 1 + ((value - black) * scale).round().clamp(0.0, 254.0) as u8,
            false => 0,
        };
        (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .map(|(column, row)| byte(self.at(column, row)))
            .collect()
    }

    /// Marching squares: pieces of the line at the threshold, and how many more there are. Where two diagonal corners lie above it, the
    /// bilinear function of the four decides at its saddle.
    fn contour(&self, threshold: f64) -> (Vec<[f64; 4]>, u64) {
        let [columns, rows] = self.pixels;
        let (mut pieces, mut left_out) = (Vec::new(), 0);
        for row in 0..rows.saturating_sub(1) {
            for column in 0..columns.saturating_sub(1) {
                let corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
                    .map(|(dx, dy)| self.at(column + dx, row + dy) - threshold);
                for piece in pieces_of(corners) {
                    if pieces.len() == MOST_PIECES {
                        left_out += 1;
                        continue;
                    }
                    let [a, b] = piece.map(|[x, y]| {
                        [x + column as f64, y + row as f64].map(|at| rounded(at * self.step as f64))
                    });
                    pieces.push([a[0], a[1], b[0], b[1]]);
                }
            }
        }
        (pieces, left_out)
    }
}

/// The line of zeros between four corners, counter-clockwise from (0, 0): at most two pieces.
fn pieces_of(corners: [f64; 4]) -> Vec<[[f64; 2]; 2]> {
    if corners.iter().any(|value| !value.is_finite()) {
        return Vec::new();
    }
    let crossed = (0..4).filter_map(|side| {
        let (a, b) = (corners[side], corners[(side + 1) % 4]);
        ((a >= 0.0) != (b >= 0.0)).then(|| {
            let (from, to) = (CORNERS[side], CORNERS[(side + 1) % 4]);
            let share = a / (a - b);
            [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        })
    });
    let crossed: Vec<[f64; 2]> = crossed.collect();
    match crossed[..] {
        [a, b] => vec![[a, b]],
        [a, b, c, d] => {
            let [p, q, r, s] = corners;
            // The value at the saddle has the sign of p·r − q·s over that of p + r − q − s, which is p's.
            let joins_first = (p * r - q * s >= 0.0) == (p + r - q - s >= 0.0);
            // Sides 0 to 3 begin at corners 0 to 3: the corner between sides 3 and 0 is the first.
            let cuts_first = joins_first != (p >= 0.0);
            if cuts_first { vec![[d, a], [b, c]] } else { vec![[a, b], [c, d]] }
        }
        _ => Vec::new(),
    }
}

/// To a thousandth of a sample.
fn rounded(at: f64) -> f64 {
    (at * 1e3).round() / 1e3
}

const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
/// Pixels a side of a picture: 256 kB a slice.
const MOST_PIXELS: usize = 512;
/// Pieces of a contour: those of 20 lines across a picture.
const MOST_PIECES: usize = 20_000;

#[cfg(test)]
mod tests {
    use asphera_report::SliceAxis;

    use super::*;
    use crate::Lattice;

    fn scan(size: [usize; 3], value: impl Fn([f64; 3]) -> f64) -> Scan {
        let mut values = Vec::new();
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    values.push(value([x, y, z].map(|side| side as f64)) as f32);
                }
            }
        }
        let steps_mm = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.2]];
        Scan { values, size, lattice: Lattice { origin_mm: [0.0; 3], steps_mm } }
    }

    fn asked(axis: SliceAxis, index: u64) -> SliceRequest {
        SliceRequest { axis, index }
    }

    /// Slices of a ramp, whose bytes and contours are known.
    #[test]
    fn slices_hold_the_samples_of_their_plane() {
        let scan = scan([5, 4, 3], |[x, y, z]| x + 10.0 * y + 100.0 * z);
        let of = |axis, index, threshold| scan.slice(asked(axis, index), [0.0, 254.0], threshold);
        let z = of(SliceAxis::Z, 1, 112.5).unwrap();
        assert_eq!((z.columns, z.rows, z.step), (5, 4, 1));
        assert_eq!(z.pixels[..6], [101, 102, 103, 104, 105, 111]);
        let x = of(SliceAxis::X, 2, 1e9).unwrap();
        assert_eq!((x.columns, x.rows), (4, 3));
        assert_eq!(x.pixels[..5], [3, 13, 23, 33, 103]);
        assert_eq!(x.contour, Vec::<[f64; 4]>::new());
        let y = of(SliceAxis::Y, 3, 1e9).unwrap();
        assert_eq!(y.pixels[..6], [31, 32, 33, 34, 35, 131]);
        // x + 10·y = 12.5: all ends lie on that line.
        assert!(!z.contour.is_empty());
        for [x1, y1, x2, y2] in z.contour {
            assert!((x1 + 10.0 * y1 - 12.5).abs() < 0.011 && (x2 + 10.0 * y2 - 12.5).abs() < 0.011);
        }
        let refused = of(SliceAxis::Z, 3, 0.0).unwrap_err().to_string();
        assert_eq!(refused, "no slice 3 across z: expected 0 to 2");
    }

    /// The line round a disc is closed, and as long as its circle.
    #[test]
    fn the_contour_of_a_ball_is_a_circle() {
        let (middle, radius) = (20.3, 12.4);
        let scan = scan([41, 41, 41], |place| {
            radius - place.map(|side| (side - middle).powi(2)).iter().sum::<f64>().sqrt()
        });
        let slice = scan.slice(asked(SliceAxis::Y, 24), [-1.0, 1.0], 0.0).unwrap();
        let expected = (radius * radius - (24.0 - middle) * (24.0 - middle)).sqrt();
        let mut long = 0.0;
        let mut ends = std::collections::BTreeMap::<[u64; 2], usize>::new();
        for [x1, y1, x2, y2] in slice.contour {
            long += (x2 - x1).hypot(y2 - y1);
            assert!(((x1 - middle).hypot(y1 - middle) - expected).abs() < 0.03);
            for end in [[x1, y1], [x2, y2]] {
                *ends.entry(end.map(f64::to_bits)).or_default() += 1;
            }
        }
        assert!(ends.values().all(|&count| count == 2), "{ends:?}");
        assert!((long / (std::f64::consts::TAU * expected) - 1.0).abs() < 0.005, "{long}");
    }

    /// Against the bilinear function at places of a fine grid: corners that the line parts are those that no path above zero joins.
    #[test]
    fn saddles_are_those_of_the_bilinear_function() {
        let cases = [[3.0, -1.0, 2.0, -1.0], [1.0, -3.0, 1.0, -2.0], [-3.0, 1.0, -2.0, 1.0]];
        for corners in cases {
            let [p, q, r, s] = corners;
            let saddle = [p - s, p - q].map(|along| along / (p + r - q - s));
            let [x, y] = saddle;
            let value =
                p * (1.0 - x) * (1.0 - y) + q * x * (1.0 - y) + r * x * y + s * (1.0 - x) * y;
            let pieces = pieces_of(corners);
            assert_eq!(pieces.len(), 2);
            // Corners 0 and 2 are joined where the saddle has their sign: then no piece cuts corner 0 off.
            let is_joined = (value >= 0.0) == (p >= 0.0);
            let cuts_first = pieces.iter().any(|[a, b]| {
                let ends = [*a, *b];
                ends.iter().any(|end| end[1] == 0.0) && ends.iter().any(|end| end[0] == 0.0)
            });
            assert_eq!(cuts_first, !is_joined, "{corners:?}");
        }
        assert!(pieces_of([f64::NAN, 1.0, -1.0, 1.0]).is_empty());
    }

    #[test]
    fn pictures_are_bounded() {
        let scan =
            scan([1100, 3, 1], |[x, y, _]| if (x + y) % 2.0 == 0.0 { 1.0 } else { f64::NAN });
        let slice = scan.slice(asked(SliceAxis::Z, 0), [0.0, 1.0], 0.5).unwrap();
        assert_eq!((slice.columns, slice.rows, slice.step), (367, 1, 3));
        assert_eq!(slice.pixels[..4], [255, 0, 255, 0]);
    }
}
