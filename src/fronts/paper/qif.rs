//! The results as a QIF 3.0 document (ANSI QIF 3.0, ISO 23952:2020).

use std::collections::BTreeMap;
use std::io;

use asphera_report::{Check, Report, Status};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use sha2::{Digest, Sha256};

use super::provenance::Provenance;
use super::words::printable;

/// The namespace of QIF 3.
pub const QIF_NAMESPACE: &str = "http://qifstandards.org/xsd/qif3";

/// The results of a report as a QIF document of the application Results.
///
/// Each limit of the verdict that is a length becomes a characteristic `OtherForm`, which QIF has for forms
/// it has no type of its own for: definition with the tolerance, nominal, item, measurement with value and
/// status. All figures of the form and of standards, which need no tolerance, stand as attributes
/// of the results, with unit and variant in the name. QIF's surface texture is Ra of a profile alone, so texture has no
/// other place. Lengths are in mm. The same report gives the same bytes: the identifier of the
/// document is made from its content.
pub fn qif(report: &Report, provenance: &Provenance) -> String {
    let mut body = Xml::new_with_indent(Vec::new(), b' ', INDENT);
    // Writing into a Vec cannot fail.
    let _ = write_body(&mut body, report, provenance);
    let identifier = identifier(&body.into_inner());
    let mut document = Xml::new_with_indent(Vec::new(), b' ', INDENT);
    let _ = write_document(&mut document, &identifier, report, provenance);
    let mut text = String::from_utf8(document.into_inner()).unwrap_or_default();
    text.push('\n');
    text
}

type Xml = Writer<Vec<u8>>;

fn write_document(
    xml: &mut Xml,
    identifier: &str,
    report: &Report,
    provenance: &Provenance,
) -> io::Result<()> {
    // Standard and results have one each, every characteristic four.
    let id_max = RESULTS_ID + 4 * lengths(report).len() as u64;
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element("QIFDocument")
        .with_attribute(("xmlns", QIF_NAMESPACE))
        .with_attribute(("versionQIF", "3.0.0"))
        .with_attribute(("idMax", &id_max.to_string()[..]))
        .write_inner_content(|xml| {
            text(xml, "QPId", identifier)?;
            write_body(xml, report, provenance)
        })?;
    Ok(())
}

fn write_body(xml: &mut Xml, report: &Report, provenance: &Provenance) -> io::Result<()> {
    inside(xml, "Header", |xml| {
        inside(xml, "Application", |xml| {
            text(xml, "Name", &Provenance::software())?;
            text(xml, "Organization", "asphera")
        })
    })?;
    counted(xml, "StandardsDefinitions", 1, |xml| {
        identified(xml, "Standard", STANDARD_ID, |xml| {
            inside(xml, "Organization", |xml| text(xml, "StandardsOrganizationEnum", "ISO"))?;
            text(xml, "Designator", "10110-5")?;
            text(xml, "Year", "2015")
        })
    })?;
    inside(xml, "FileUnits", |xml| {
        inside(xml, "PrimaryUnits", |xml| {
            inside(xml, "LinearUnit", |xml| {
                text(xml, "SIUnitName", "meter")?;
                text(xml, "UnitName", "mm")?;
                inside(xml, "UnitConversion", |xml| text(xml, "Factor", "0.001"))
            })
        })
    })?;
    let lengths = lengths(report);
    if !lengths.is_empty() {
        inside(xml, "Characteristics", |xml| characteristics(xml, report, &lengths))?;
    }
    inside(xml, "Results", |xml| {
        counted(xml, "MeasurementResultsSet", 1, |xml| {
            identified(xml, "MeasurementResults", RESULTS_ID, |xml| {
                results(xml, report, provenance, &lengths)
            })
        })
    })
}

/// Requirements on the part: four aspects of every characteristic, of which the first three stand here.
fn characteristics(xml: &mut Xml, report: &Report, lengths: &[Length<'_>]) -> io::Result<()> {
    let count = lengths.len();
    let nominal = report.form.as_ref().map_or("", |form| form.nominal.as_str());
    text(xml, "FormalStandardId", &STANDARD_ID.to_string())?;
    counted(xml, "CharacteristicDefinitions", count, |xml| {
        lengths.iter().try_for_each(|length| {
            identified(xml, "OtherFormCharacteristicDefinition", length.id, |xml| {
                let what =
                    format!("{} of the deviation from {nominal} along its normal", length.name);
                text(xml, "Description", &what)?;
                text(xml, "Name", &length.name)?;
                text(xml, "ToleranceValue", &decimal_mm(length.check.limit))
            })
        })
    })?;
    counted(xml, "CharacteristicNominals", count, |xml| {
        lengths.iter().try_for_each(|length| {
            identified(xml, "OtherFormCharacteristicNominal", length.id + 1, |xml| {
                text(xml, "CharacteristicDefinitionId", &length.id.to_string())?;
                text(xml, "Name", &length.name)
            })
        })
    })?;
    counted(xml, "CharacteristicItems", count, |xml| {
        lengths.iter().try_for_each(|length| {
            identified(xml, "OtherFormCharacteristicItem", length.id + 2, |xml| {
                text(xml, "Name", &length.name)?;
                text(xml, "CharacteristicNominalId", &(length.id + 1).to_string())
            })
        })
    })
}

fn results(
    xml: &mut Xml,
    report: &Report,
    provenance: &Provenance,
    lengths: &[Length<'_>],
) -> io::Result<()> {
    let attributes = attributes(report, provenance);
    counted(xml, "Attributes", attributes.len(), |xml| {
        attributes.iter().try_for_each(|(name, value)| {
            xml.create_element("AttributeStr")
                .with_attribute(("name", &printable(name)[..]))
                .with_attribute(("value", &printable(value)[..]))
                .write_empty()?;
            Ok(())
        })
    })?;
    if !lengths.is_empty() {
        inside(xml, "MeasuredCharacteristics", |xml| {
            counted(xml, "CharacteristicMeasurements", lengths.len(), |xml| {
                lengths.iter().try_for_each(|length| measurement(xml, report, length))
            })
        })?;
    }
    let status = match report.verdict.status {
        Status::Pass => "PASS",
        Status::Fail => "FAIL",
        Status::Undecided | Status::None => "UNKNOWN",
    };
    inside(xml, "InspectionStatus", |xml| text(xml, "InspectionStatusEnum", status))
}

fn measurement(xml: &mut Xml, report: &Report, length: &Length<'_>) -> io::Result<()> {
    let status = match report.verdict.status {
        Status::Pass | Status::Fail if length.check.ok => "PASS",
        Status::Pass | Status::Fail if length.check.is_broken() => "FAIL",
        _ => "INDETERMINATE",
    };
    identified(xml, "OtherFormCharacteristicMeasurement", length.id + 3, |xml| {
        inside(xml, "Status", |xml| text(xml, "CharacteristicStatusEnum", status))?;
        text(xml, "CharacteristicItemId", &(length.id + 2).to_string())?;
        if let Some(session) = &report.session {
            text(xml, "TimeStamp", &session.started)?;
        }
        text(xml, "Value", &decimal_mm(length.check.value))
    })
}

/// An element that holds others.
fn inside(
    xml: &mut Xml,
    name: &str,
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    xml.create_element(name).write_inner_content(content)?;
    Ok(())
}

/// An element that holds others and says how many.
fn counted(
    xml: &mut Xml,
    name: &str,
    count: usize,
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let count = count.to_string();
    xml.create_element(name).with_attribute(("n", &count[..])).write_inner_content(content)?;
    Ok(())
}

/// An element with an id, which holds others.
fn identified(
    xml: &mut Xml,
    name: &str,
    id: u64,
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let id = id.to_string();
    xml.create_element(name).with_attribute(("id", &id[..])).write_inner_content(content)?;
    Ok(())
}

/// An element that holds words.
fn text(xml: &mut Xml, name: &str, words: &str) -> io::Result<()> {
    xml.create_element(name).write_text_content(BytesText::new(&printable(words)))?;
    Ok(())
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
    for (name, entry) in provenance.label_of(report).entries() {
        add(name, entry.to_owned());
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
        for figure in form.figures.iter().chain(form.standards.figures()) {
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
    if let Some(form) = &report.form {
        form.standards.facts().into_iter().for_each(|(name, value)| add(name, value));
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
fn identifier(content: &[u8]) -> String {
    let hash = Sha256::digest(content);
    let mut bytes = [0; 16];
    bytes.copy_from_slice(&hash[..16]);
    bytes[6] = bytes[6] & 0x0f | 0x80;
    bytes[8] = bytes[8] & 0x3f | 0x80;
    let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("{}-{}-{}-{}-{}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

const STANDARD_ID: u64 = 1;
const RESULTS_ID: u64 = 2;
/// Spaces of a level.
const INDENT: usize = 2;
