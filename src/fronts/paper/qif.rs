//! The results as a QIF 3.0 document (ANSI QIF 3.0, ISO 23952:2020).

use std::collections::BTreeMap;
use std::fmt::{Result, Write as _};

use asphera_report::{Check, Report, Status};
use sha2::{Digest, Sha256};

use super::provenance::Provenance;
use super::words::text;

/// The namespace of QIF 3.
pub const QIF_NAMESPACE: &str = "http://qifstandards.org/xsd/qif3";

/// The results of a report as a QIF document of the application Results.
///
/// Each limit of the verdict that is a length becomes a characteristic `OtherForm`, which QIF has for forms
/// it has no type of its own for: definition with the tolerance, nominal, item, measurement with value and
/// status. All figures of the form, minimum zone, texture and indication, which need no tolerance, stand as attributes
/// of the results, with unit and variant in the name. QIF's surface texture is Ra of a profile alone, so texture has no
/// other place. Lengths are in mm. The same report gives the same bytes: the identifier of the
/// document is made from its content.
pub fn qif(report: &Report, provenance: &Provenance) -> String {
    let mut body = String::new();
    // Writing into a String cannot fail.
    let _ = write_body(&mut body, report, provenance);
    let checks = lengths(report).len() as u64;
    // Standard and results have one each, every characteristic four.
    let id_max = RESULTS_ID + 4 * checks;
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <QIFDocument xmlns=\"{QIF_NAMESPACE}\" versionQIF=\"3.0.0\" idMax=\"{id_max}\">\n\
         \x20 <QPId>{}</QPId>\n{body}</QIFDocument>\n",
        identifier(&body)
    )
}

fn write_body(out: &mut String, report: &Report, provenance: &Provenance) -> Result {
    writeln!(
        out,
        "  <Header>\n    <Application>\n      <Name>{}</Name>\n      <Organization>asphera</Organization>\n    \
         </Application>\n  </Header>",
        text(&Provenance::software())
    )?;
    writeln!(
        out,
        "  <StandardsDefinitions n=\"1\">\n    <Standard id=\"{STANDARD_ID}\">\n      <Organization>\n        \
         <StandardsOrganizationEnum>ISO</StandardsOrganizationEnum>\n      </Organization>\n      \
         <Designator>10110-5</Designator>\n      <Year>2015</Year>\n    </Standard>\n  \
         </StandardsDefinitions>"
    )?;
    out.push_str(
        "  <FileUnits>\n    <PrimaryUnits>\n      <LinearUnit>\n        <SIUnitName>meter</SIUnitName>\n        \
         <UnitName>mm</UnitName>\n        <UnitConversion>\n          <Factor>0.001</Factor>\n        \
         </UnitConversion>\n      </LinearUnit>\n    </PrimaryUnits>\n  </FileUnits>\n",
    );
    let lengths = lengths(report);
    if !lengths.is_empty() {
        characteristics(out, report, &lengths)?;
    }
    results(out, report, provenance, &lengths)
}

/// Requirements on the part: four aspects of every characteristic, of which the first three stand here.
fn characteristics(out: &mut String, report: &Report, lengths: &[Length<'_>]) -> Result {
    let count = lengths.len();
    writeln!(out, "  <Characteristics>\n    <FormalStandardId>{STANDARD_ID}</FormalStandardId>")?;
    writeln!(out, "    <CharacteristicDefinitions n=\"{count}\">")?;
    for length in lengths {
        let (id, limit) = (length.id, decimal_mm(length.check.limit));
        let nominal = report.form.as_ref().map_or("", |form| form.nominal.as_str());
        writeln!(
            out,
            "      <OtherFormCharacteristicDefinition id=\"{id}\">\n        <Description>{} of the deviation from \
             {} along its normal</Description>\n        <Name>{}</Name>\n        \
             <ToleranceValue>{limit}</ToleranceValue>\n      </OtherFormCharacteristicDefinition>",
            text(&length.name),
            text(nominal),
            text(&length.name)
        )?;
    }
    writeln!(out, "    </CharacteristicDefinitions>\n    <CharacteristicNominals n=\"{count}\">")?;
    for length in lengths {
        writeln!(
            out,
            "      <OtherFormCharacteristicNominal id=\"{}\">\n        \
             <CharacteristicDefinitionId>{}</CharacteristicDefinitionId>\n        <Name>{}</Name>\n      \
             </OtherFormCharacteristicNominal>",
            length.id + 1,
            length.id,
            text(&length.name)
        )?;
    }
    writeln!(out, "    </CharacteristicNominals>\n    <CharacteristicItems n=\"{count}\">")?;
    for length in lengths {
        writeln!(
            out,
            "      <OtherFormCharacteristicItem id=\"{}\">\n        <Name>{}</Name>\n        \
             <CharacteristicNominalId>{}</CharacteristicNominalId>\n      </OtherFormCharacteristicItem>",
            length.id + 2,
            text(&length.name),
            length.id + 1
        )?;
    }
    out.push_str("    </CharacteristicItems>\n  </Characteristics>\n");
    Ok(())
}

fn results(
    out: &mut String,
    report: &Report,
    provenance: &Provenance,
    lengths: &[Length<'_>],
) -> Result {
    writeln!(
        out,
        "  <Results>\n    <MeasurementResultsSet n=\"1\">\n      <MeasurementResults id=\"{RESULTS_ID}\">"
    )?;
    let attributes = attributes(report, provenance);
    writeln!(out, "        <Attributes n=\"{}\">", attributes.len())?;
    for (name, value) in attributes {
        writeln!(
            out,
            "          <AttributeStr name=\"{}\" value=\"{}\"/>",
            text(&name),
            text(&value)
        )?;
    }
    out.push_str("        </Attributes>\n");
    if !lengths.is_empty() {
        writeln!(
            out,
            "        <MeasuredCharacteristics>\n          <CharacteristicMeasurements n=\"{}\">",
            lengths.len()
        )?;
        for length in lengths {
            measurement(out, report, length)?;
        }
        out.push_str(
            "          </CharacteristicMeasurements>\n        </MeasuredCharacteristics>\n",
        );
    }
    let status = match report.verdict.status {
        Status::Pass => "PASS",
        Status::Fail => "FAIL",
        Status::Undecided | Status::None => "UNKNOWN",
    };
    writeln!(
        out,
        "        <InspectionStatus>\n          <InspectionStatusEnum>{status}</InspectionStatusEnum>\n        \
         </InspectionStatus>\n      </MeasurementResults>\n    </MeasurementResultsSet>\n  </Results>"
    )
}

fn measurement(out: &mut String, report: &Report, length: &Length<'_>) -> Result {
    let status = match report.verdict.status {
        Status::Pass | Status::Fail if length.check.ok => "PASS",
        Status::Pass | Status::Fail if length.check.is_broken() => "FAIL",
        _ => "INDETERMINATE",
    };
    writeln!(
        out,
        "            <OtherFormCharacteristicMeasurement id=\"{}\">\n              <Status>\n                \
         <CharacteristicStatusEnum>{status}</CharacteristicStatusEnum>\n              </Status>\n              \
         <CharacteristicItemId>{}</CharacteristicItemId>",
        length.id + 3,
        length.id + 2
    )?;
    if let Some(session) = &report.session {
        writeln!(out, "              <TimeStamp>{}</TimeStamp>", text(&session.started))?;
    }
    writeln!(
        out,
        "              <Value>{}</Value>\n            </OtherFormCharacteristicMeasurement>",
        decimal_mm(length.check.value)
    )
}

/// Content that QIF has no place for that needs no tolerance: figures, coverage, fit, session, files. A name is unique within an entity
/// (Primitives.xsd, AttributeBaseType): from the second on, those that are equal are numbered.
fn attributes(report: &Report, provenance: &Provenance) -> Vec<(String, String)> {
    let mut attributes = vec![("software".to_owned(), Provenance::software())];
    let mut named: BTreeMap<String, usize> = BTreeMap::new();
    let mut add = |name: &str, value: String| {
        let count = named.entry(name.to_owned()).or_default();
        *count += 1;
        let name = if *count == 1 { name.to_owned() } else { format!("{name} ({count})") };
        attributes.push((name, value));
    };
    let label = report.session.as_ref().map(|session| &session.label);
    if let Some(part) = &provenance.part {
        add("part", part.clone());
    }
    for (name, entry) in label.iter().flat_map(|label| label.entries()) {
        // Whoever asks for the paper names the part; else who started the session did.
        if name != "part" || provenance.part.is_none() {
            add(name, entry.to_owned());
        }
    }
    if let Some(session) = &report.session {
        add("session", session.id.clone());
        add("station", session.station.clone());
    }
    if let Some(coverage) = report.sampling.coverage {
        add("coverage of the aperture", coverage.to_string());
    }
    if let Some(form) = &report.form {
        add("nominal", form.nominal.clone());
        add("fit", format!("{}, {}", form.fit.method, form.fit.termination));
        for caution in &form.fit.details.cautions {
            add("caution", caution.text.clone());
        }
        add("PV / nm", form.deviation.pv_nm.to_string());
        add("RMS / nm", form.deviation.rms_nm.to_string());
        if let Some(of) = &form.deviation.uncertainty {
            for (name, [low, high], covers) in [
                ("PV", of.pv_95_nm, &of.pv_covers),
                ("RMS without noise", of.rms_95_nm, &of.rms_covers),
            ] {
                add(&format!("95 % of {name} / nm"), format!("{low} to {high}, by {covers}"));
            }
        }
        let of = &form.standards;
        let zone = of.minimum_zone.iter().map(|zone| &zone.width);
        let texture = of.texture.iter().flat_map(|texture| &texture.figures);
        for figure in form.figures.iter().chain(zone).chain(texture) {
            let unit = if figure.unit.is_empty() { "1" } else { &figure.unit };
            let name = format!("{}, {} / {unit}", figure.name, figure.variant);
            add(&name, figure.value.to_string());
            if let Some(u) = figure.u {
                add(&format!("u of {name}"), u.to_string());
            }
            if let Some(of) = &figure.simulated {
                let percent = 100.0 * of.p;
                let interval = format!("{} to {}, by {}", of.low, of.high, of.covers);
                add(&format!("{percent} % of {name}"), interval);
            }
        }
    }
    if let Some(of) = report.form.as_ref().map(|form| &form.standards) {
        if let Some(zone) = &of.minimum_zone {
            add("minimum zone, lower bound / nm", zone.lower_nm.to_string());
        }
        if let Some(texture) = &of.texture {
            add("texture, surface", texture.surface.clone());
            for filter in &texture.filters {
                add("texture, filter", filter.clone());
            }
        }
        if let Some(indication) = &of.indication {
            add("ISO 10110-5, found", indication.found.clone());
            indication.asked.iter().for_each(|asked| add("ISO 10110-5, asked", asked.clone()));
        }
    }
    for reason in &report.verdict.reasons {
        add("reason", reason.clone());
    }
    for file in &provenance.files {
        add(&format!("SHA-256 of {}", file.name), file.sha256.clone());
    }
    attributes
}

/// A limit that is a length, and the first of the four ids of its characteristic.
struct Length<'a> {
    check: &'a Check,
    name: String,
    id: u64,
}

fn lengths(report: &Report) -> Vec<Length<'_>> {
    let in_nm = report.verdict.checks.iter().filter_map(|check| {
        let is_length =
            check.figure.unit == "nm" && check.value.is_finite() && check.limit.is_finite();
        is_length.then(|| (check, check.figure.words()))
    });
    in_nm
        .zip(0..)
        .map(|((check, name), index)| Length { check, name, id: RESULTS_ID + 1 + 4 * index })
        .collect()
}

/// Nanometres as a decimal number of mm: `xs:decimal` knows no exponent.
fn decimal_mm(nm: f64) -> String {
    format!("{:.12}", nm * 1e-6)
}

/// An identifier from the content: the first 128 bits of its SHA-256 as a UUID of version 8 (RFC 9562, 5.8).
fn identifier(content: &str) -> String {
    let hash = Sha256::digest(content.as_bytes());
    let mut bytes = [0; 16];
    bytes.copy_from_slice(&hash[..16]);
    bytes[6] = bytes[6] & 0x0f | 0x80;
    bytes[8] = bytes[8] & 0x3f | 0x80;
    let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("{}-{}-{}-{}-{}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

const STANDARD_ID: u64 = 1;
const RESULTS_ID: u64 = 2;
