//! What the queries of `/api/v1/section`, `/api/v1/form` and `/api/v1/volume/slice` ask for.

use asphera_report::{SectionRequest, SliceAxis, SliceRequest, Term};
use axum::http::StatusCode;

use super::problem::Problem;

/// Reads `line=X1,Y1,X2,Y2`, `circle=X,Y,R`, `radius=DEG[&centre=X,Y]` or `plane=A,B,C,D`.
pub(super) fn section(query: &str) -> Result<SectionRequest, Problem> {
    let (mut path, mut centre) = (None, None);
    for (key, value) in query.split('&').filter(|part| !part.is_empty()).map(parted) {
        // Commas may come escaped; nothing else that a number has does.
        let value = value.replace("%2C", ",").replace("%2c", ",").replace("%2B", "+");
        let taken = match key {
            "line" | "circle" | "radius" | "plane" => path.replace(read(key, &value)?).is_some(),
            "centre" => centre.replace(numbers::<2>(key, &value, "X,Y")?).is_some(),
            _ => return Err(bad("unknown parameter of a section").expected(KEYS).found(key)),
        };
        if taken {
            return Err(bad("a section goes along one path").expected(ONE).found(query));
        }
    }
    match (path, centre) {
        (None, _) => Err(bad("a section needs a path").expected(ONE).found(query)),
        (Some(SectionRequest::Radius { angle_rad, .. }), centre_mm) => {
            Ok(SectionRequest::Radius { centre_mm, angle_rad })
        }
        (Some(_), Some(_)) => {
            Err(bad("only a radius has a centre of its own").expected(ONE).found(query))
        }
        (Some(request), None) => Ok(request),
    }
}

fn read(key: &str, value: &str) -> Result<SectionRequest, Problem> {
    Ok(match key {
        "line" => {
            let [x1, y1, x2, y2] = numbers(key, value, "X1,Y1,X2,Y2")?;
            SectionRequest::Line { from_mm: [x1, y1], to_mm: [x2, y2] }
        }
        "circle" => {
            let [x, y, radius_mm] = numbers(key, value, "X,Y,R")?;
            SectionRequest::Circle { centre_mm: [x, y], radius_mm }
        }
        "plane" => {
            let [a, b, c, offset_mm] = numbers(key, value, "A,B,C,D")?;
            SectionRequest::Plane { normal: [a, b, c], offset_mm }
        }
        _ => {
            let [angle_deg] = numbers(key, value, "DEG")?;
            SectionRequest::Radius { centre_mm: None, angle_rad: f64::to_radians(angle_deg) }
        }
    })
}

fn numbers<const N: usize>(key: &str, value: &str, form: &str) -> Result<[f64; N], Problem> {
    let found: Option<Vec<f64>> = value
        .split(',')
        .map(|number| number.trim().parse().ok().filter(|number: &f64| number.is_finite()))
        .collect();
    found.and_then(|found| found.try_into().ok()).ok_or_else(|| {
        bad(format!("the {key} of a section cannot be read"))
            .expected(format!("{key}={form}"))
            .found(value)
    })
}

/// Reads `remove=TERM,TERM,…`; nothing is removed without it.
pub(super) fn form(query: &str) -> Result<Vec<Term>, Problem> {
    let mut terms: Option<Vec<Term>> = None;
    for (key, value) in query.split('&').filter(|part| !part.is_empty()).map(parted) {
        if key != "remove" {
            return Err(bad("unknown parameter of the form").expected(REMOVE).found(key));
        }
        let value = value.replace("%2C", ",").replace("%2c", ",");
        let read: Result<_, _> =
            value.split(',').filter(|name| !name.is_empty()).map(term).collect();
        if terms.replace(read?).is_some() {
            return Err(bad("the terms to remove are given twice").expected(REMOVE).found(query));
        }
    }
    Ok(terms.unwrap_or_default())
}

fn term(name: &str) -> Result<Term, Problem> {
    Term::ALL.into_iter().find(|term| term.to_string() == name).ok_or_else(|| {
        bad("no such term to remove")
            .expected(Term::ALL.map(|term| term.to_string()).join(", "))
            .found(name)
    })
}

/// Reads `axis=x|y|z&index=N`.
pub(super) fn slice(query: &str) -> Result<SliceRequest, Problem> {
    let (mut axis, mut index) = (None, None);
    for (key, value) in query.split('&').filter(|part| !part.is_empty()).map(parted) {
        let is_twice = match key {
            "axis" => axis.replace(axis_named(value)?).is_some(),
            "index" => {
                let number = value.parse::<u64>().map_err(|_| {
                    bad("the index of a slice cannot be read").expected("index=N").found(value)
                })?;
                index.replace(number).is_some()
            }
            _ => return Err(bad("unknown parameter of a slice").expected(SLICE).found(key)),
        };
        if is_twice {
            return Err(bad("a slice has one axis and one index").expected(SLICE).found(query));
        }
    }
    match (axis, index) {
        (Some(axis), Some(index)) => Ok(SliceRequest { axis, index }),
        _ => Err(bad("a slice needs an axis and an index").expected(SLICE).found(query)),
    }
}

fn axis_named(name: &str) -> Result<SliceAxis, Problem> {
    SliceAxis::ALL
        .into_iter()
        .find(|axis| axis.name() == name)
        .ok_or_else(|| bad("no such axis of a slice").expected("axis=x, y or z").found(name))
}

fn parted(part: &str) -> (&str, &str) {
    part.split_once('=').unwrap_or((part, ""))
}

fn bad(error: impl Into<String>) -> Problem {
    Problem::new(StatusCode::BAD_REQUEST, error)
}

const KEYS: &str = "line, circle, radius, centre or plane";
const SLICE: &str = "axis=x, y or z, and index=N from 0";
const REMOVE: &str = "remove=TERM,TERM,… once";
const ONE: &str =
    "one of line=X1,Y1,X2,Y2, circle=X,Y,R, radius=DEG[&centre=X,Y] and plane=A,B,C,D";

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn paths_are_read() {
        let line = SectionRequest::Line { from_mm: [-1.0, 0.0], to_mm: [1.5, 2e-1] };
        assert_eq!(section("line=-1,0,1.5,2e-1").unwrap(), line);
        assert_eq!(section("line=-1%2C0%2c1.5,0.2").unwrap(), line);
        let circle = SectionRequest::Circle { centre_mm: [0.0, 1.0], radius_mm: 2.0 };
        assert_eq!(section("circle=0,1,2").unwrap(), circle);
        let plane = SectionRequest::Plane { normal: [0.0, -2.0, 1.0], offset_mm: 3.5 };
        assert_eq!(section("plane=0,-2,1,3.5").unwrap(), plane);
        let radius = |centre_mm| SectionRequest::Radius { centre_mm, angle_rad: FRAC_PI_2 };
        assert_eq!(section("radius=90").unwrap(), radius(None));
        assert_eq!(section("centre=1,2&radius=90").unwrap(), radius(Some([1.0, 2.0])));
    }

    #[test]
    fn terms_are_read_and_others_told() {
        assert_eq!(form("").unwrap(), []);
        assert_eq!(form("remove=").unwrap(), []);
        assert_eq!(
            form("remove=tilt%2Cpower,coma").unwrap(),
            [Term::Tilt, Term::Power, Term::Coma]
        );
        for (query, what) in [
            ("remove=tilt,trefoil", "piston, tilt, power, astigmatism, coma, spherical"),
            ("remove=Tilt", "no such term"),
            ("remove=tilt&remove=power", "given twice"),
            ("terms=tilt", "unknown parameter"),
        ] {
            let problem = form(query).unwrap_err();
            assert!(format!("{problem:?}").contains(what), "{query}: {problem:?}");
        }
    }

    #[test]
    fn slices_are_read_and_others_told() {
        let y = SliceRequest { axis: SliceAxis::Y, index: 41 };
        assert_eq!(slice("axis=y&index=41").unwrap(), y);
        assert_eq!(slice("index=41&axis=y").unwrap(), y);
        for (query, what) in [
            ("", "needs an axis"),
            ("axis=y", "needs an axis"),
            ("axis=w&index=1", "no such axis"),
            ("axis=z&index=-1", "cannot be read"),
            ("axis=z&index=1.5", "cannot be read"),
            ("axis=z&axis=y&index=1", "one axis and one index"),
            ("axis=z&slice=1", "unknown parameter"),
        ] {
            let problem = slice(query).unwrap_err();
            assert!(format!("{problem:?}").contains(what), "{query}: {problem:?}");
        }
    }

    #[test]
    fn what_is_no_path_is_told() {
        for (query, what) in [
            ("", "needs a path"),
            ("centre=1,2", "needs a path"),
            ("line=1,2,3", "line of a section"),
            ("line=1,2,3,4,5", "line of a section"),
            ("line=1,2,3,x", "line of a section"),
            ("circle=0,0,NaN", "circle of a section"),
            ("radius=inf", "radius of a section"),
            ("radius", "radius of a section"),
            ("plane=0,0,1", "plane of a section"),
            ("plane=0,0,1,0&line=0,0,1,1", "one path"),
            ("radius=1&line=0,0,1,1", "one path"),
            ("radius=1&radius=2", "one path"),
            ("line=0,0,1,1&centre=0,0", "centre of its own"),
            ("lines=0,0,1,1", "unknown parameter"),
        ] {
            let problem = section(query).unwrap_err();
            assert!(format!("{problem:?}").contains(what), "{query}: {problem:?}");
        }
    }
}
