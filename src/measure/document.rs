//! A measurement as documents ask for it.

use asphera_report::{Cut, Measured, Picture, Report, SectionRequest};

use super::deviation_map::DeviationMap;
use super::measurement::Measurement;

impl Measured for Measurement {
    fn report(&self) -> &Report {
        &self.report
    }

    fn picture(&self) -> Option<Picture> {
        self.map.as_ref().map(DeviationMap::picture)
    }

    fn on_plane(&self, part_mm: [f64; 3]) -> Option<[f64; 3]> {
        self.surface.on_plane(part_mm)
    }

    fn extent_mm(&self) -> Option<[[f64; 2]; 2]> {
        self.surface.extent_mm()
    }

    fn aperture_extent_mm(&self) -> Option<[[f64; 2]; 2]> {
        self.surface.aperture_extent_mm()
    }

    fn counts_at(&self, place_mm: [f64; 2]) -> bool {
        self.surface.counts_at(place_mm)
    }

    fn section(&self, request: &SectionRequest) -> Cut {
        self.surface.section(request)
    }
}
