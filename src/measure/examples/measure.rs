//! Measures a file of points against a nominal file: `measure NOMINAL.toml POINTS.xyz`.

#![expect(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use asphera_measure::{Along, Pipeline};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [nominal, points] = &arguments[..] else {
        return Err("expected two files: NOMINAL.toml POINTS.xyz".into());
    };
    let part = asphera_nominal::parse(nominal, &std::fs::read_to_string(nominal)?)?;
    let file = asphera_formats::read(points, &std::fs::read(points)?)?;
    let mut pipeline = Pipeline::along(part, Along::Z);
    pipeline.take_positions(file.points());
    let report = pipeline.finish().report;
    let form = report.form.ok_or("no fit could be made")?;
    println!("verdict {:?}", report.verdict.status);
    println!("PV      {:.2} nm", form.deviation.pv_nm);
    println!("RMS     {:.2} nm", form.deviation.rms_nm);
    report.verdict.reasons.iter().for_each(|reason| println!("reason  {reason}"));
    Ok(())
}
