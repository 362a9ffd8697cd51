//! The functions that the command line names.

use std::str::FromStr;

use asphera_graph::Cloud;
use asphera_graph::functions::{
    self, Field, FunctionError, distance_from_axis, distance_from_centre, distance_from_point,
};

/// A function by its name.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::cli) enum FunctionChoice {
    Height([f64; 3]),
    Principal(usize),
    Centre,
    Point([f64; 3]),
    Axis([f64; 3], [f64; 3]),
    Logarithm,
    Square,
    Saddle,
    GeodesicEnds,
    GeodesicMean(usize),
    Laplacian(usize),
    Harmonic,
    Heat(f64),
    /// The numbers of a column of the file, counted from 1.
    Column(usize),
    /// The place of each point in the order in which they came.
    Arrival,
}

impl FromStr for FunctionChoice {
    type Err = String;

    fn from_str(word: &str) -> Result<FunctionChoice, String> {
        let (name, argument) = word.split_once(':').unwrap_or((word, ""));
        let numbers: Option<Vec<f64>> = argument
            .split(',')
            .map(|word| word.parse().ok().filter(|v: &f64| v.is_finite()))
            .collect();
        let numbers = numbers.unwrap_or_default();
        let found = match (name, argument, &numbers[..]) {
            ("height", "x", _) => Some(FunctionChoice::Height([1.0, 0.0, 0.0])),
            ("height", "y", _) => Some(FunctionChoice::Height([0.0, 1.0, 0.0])),
            ("height", "z" | "", _) => Some(FunctionChoice::Height([0.0, 0.0, 1.0])),
            ("height", _, &[x, y, z]) => Some(FunctionChoice::Height([x, y, z])),
            ("pca", "1", _) => Some(FunctionChoice::Principal(1)),
            ("pca", "2", _) => Some(FunctionChoice::Principal(2)),
            ("pca", "3", _) => Some(FunctionChoice::Principal(3)),
            ("centre", "", _) => Some(FunctionChoice::Centre),
            ("point", _, &[x, y, z]) => Some(FunctionChoice::Point([x, y, z])),
            ("axis", _, &[x, y, z, a, b, c]) => Some(FunctionChoice::Axis([x, y, z], [a, b, c])),
            ("log", "", _) => Some(FunctionChoice::Logarithm),
            ("square", "", _) => Some(FunctionChoice::Square),
            ("saddle", "", _) => Some(FunctionChoice::Saddle),
            ("geodesic", "", _) => Some(FunctionChoice::GeodesicEnds),
            ("geodesic", _, _) => argument.parse().ok().map(FunctionChoice::GeodesicMean),
            ("laplacian", _, _) => argument.parse().ok().map(FunctionChoice::Laplacian),
            ("harmonic", "", _) => Some(FunctionChoice::Harmonic),
            ("heat", _, &[time]) => Some(FunctionChoice::Heat(time)),
            ("arrival", "", _) => Some(FunctionChoice::Arrival),
            ("column", ..) => {
                argument.parse().ok().filter(|&column| column > 0).map(FunctionChoice::Column)
            }
            _ => None,
        };
        found.ok_or_else(|| {
            format!(
                "expected height:x, height:y, height:z, height:DX,DY,DZ, pca:1, pca:2, pca:3, centre, point:X,Y,Z, \
                 axis:X,Y,Z,DX,DY,DZ, log, square, saddle, geodesic, geodesic:N, laplacian:N, harmonic, heat:T, arrival or column:N, found `{word}`"
            )
        })
    }
}

impl FunctionChoice {
    /// The name as the report writes it.
    pub(in crate::cli) fn kind(&self) -> String {
        let list = |values: &[f64]| {
            let words: Vec<String> = values.iter().map(ToString::to_string).collect();
            words.join(",")
        };
        match self {
            FunctionChoice::Height(direction) => format!("height:{}", list(direction)),
            FunctionChoice::Principal(axis) => format!("pca:{axis}"),
            FunctionChoice::Centre => "centre".into(),
            FunctionChoice::Point(point) => format!("point:{}", list(point)),
            FunctionChoice::Axis(point, along) => format!("axis:{},{}", list(point), list(along)),
            FunctionChoice::Logarithm => "log".into(),
            FunctionChoice::Square => "square".into(),
            FunctionChoice::Saddle => "saddle".into(),
            FunctionChoice::GeodesicEnds => "geodesic".into(),
            FunctionChoice::GeodesicMean(count) => format!("geodesic:{count}"),
            FunctionChoice::Laplacian(number) => format!("laplacian:{number}"),
            FunctionChoice::Harmonic => "harmonic".into(),
            FunctionChoice::Heat(time) => format!("heat:{time}"),
            FunctionChoice::Column(column) => format!("column:{column}"),
            FunctionChoice::Arrival => "arrival".into(),
        }
    }

    /// The function of a cloud; `values` are those of the column or of arrival, one a point of the file.
    pub(in crate::cli) fn field(
        &self,
        cloud: &Cloud<3>,
        values: Option<&[f64]>,
    ) -> Result<Field, FunctionError> {
        match *self {
            FunctionChoice::Column(_) | FunctionChoice::Arrival => {
                // Points at one place share the middle of their values.
                let values = values.map_or_else(Vec::new, |values| cloud.by_place(values));
                Ok(Field::given(values))
            }
            FunctionChoice::Height(direction) => functions::height(cloud, direction),
            FunctionChoice::Principal(axis) => functions::principal_height(cloud, axis),
            FunctionChoice::Centre => distance_from_centre(cloud),
            FunctionChoice::Point(point) => distance_from_point(cloud, point),
            FunctionChoice::Axis(point, along) => distance_from_axis(cloud, point, along),
            FunctionChoice::Logarithm => Ok(functions::logarithm(cloud)),
            FunctionChoice::Square => Ok(functions::squared_norm(cloud)),
            FunctionChoice::Saddle => Ok(functions::saddle(cloud)),
            FunctionChoice::GeodesicEnds => {
                functions::geodesic_from_ends(cloud, &cloud.nearest(GEODESIC_NEIGHBOURS)?)
            }
            FunctionChoice::GeodesicMean(count) => {
                functions::geodesic_mean(cloud, &cloud.nearest(GEODESIC_NEIGHBOURS)?, count)
            }
            FunctionChoice::Laplacian(number) => {
                functions::eigenfunction(cloud, &cloud.nearest(GEODESIC_NEIGHBOURS)?, number)
            }
            FunctionChoice::Harmonic => {
                functions::harmonic_between_ends(cloud, &cloud.nearest(GEODESIC_NEIGHBOURS)?)
            }
            FunctionChoice::Heat(time) => {
                functions::heat_kernel(cloud, &cloud.nearest(GEODESIC_NEIGHBOURS)?, time)
            }
        }
    }
}

/// Neighbours between which geodesic fronts move and heat flows.
const GEODESIC_NEIGHBOURS: usize = 12;
