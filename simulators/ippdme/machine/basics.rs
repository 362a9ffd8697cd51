//! Commands that move nothing.

use asphera_ippdme::wire::{Argument, Call, Severity};

use super::{Column, Done, Failure, Machine};

/// Tools of the machine.
pub(super) const TOOLS: [&str; 3] = ["NoTool", "RefTool", "Probe1"];

impl Machine {
    pub(super) fn basic(&mut self, call: &Call) -> Result<Done, Failure> {
        let data = match call.name.as_str() {
            "StartSession" => {
                self.has_session = true;
                self.point_columns = vec![Column::X, Column::Y, Column::Z];
                self.scan_columns = vec![Column::X, Column::Y, Column::Z, Column::Q];
                Vec::new()
            }
            "EndSession" => {
                self.has_session = false;
                Vec::new()
            }
            "ClearAllErrors" => {
                self.error = None;
                Vec::new()
            }
            "GetErrStatusE" => vec![format!("ErrStatus({})", u8::from(self.error.is_some()))],
            "GetErrorInfo" => vec![info(call)?],
            "GetDMEVersion" => vec!["DMEVersion(\"1.4.3\")".to_owned()],
            "GetMachineClass" => vec!["GetMachineClass(\"CartCMM\")".to_owned()],
            "IsHomed" => vec![format!("IsHomed({})", u8::from(self.is_homed))],
            "EnumTools" => TOOLS.iter().map(|tool| format!("\"{tool}\"")).collect(),
            "OnPtMeasReport" => {
                self.point_columns = columns(call)?;
                Vec::new()
            }
            "OnScanReport" => {
                self.scan_columns = columns(call)?;
                Vec::new()
            }
            "Get" => {
                let columns = columns(call)?;
                let item = |column: &Column| self.item(*column, self.place, 0.0);
                vec![columns.iter().map(item).collect::<Vec<_>>().join(", ")]
            }
            "SetProp" => {
                self.set_speeds(call)?;
                Vec::new()
            }
            _ => return Err((Severity::Critical, 501, "Unsupported command")),
        };
        Ok(Done::Now(data))
    }

    fn set_speeds(&mut self, call: &Call) -> Result<(), Failure> {
        for argument in &call.arguments {
            let Argument::Group(property) = argument else {
                return Err((Severity::Critical, 509, "Bad argument"));
            };
            let settings = &mut self.settings;
            let speed = match property.name.trim_end_matches(".Act") {
                "Tool.GoToPar.Speed" => &mut settings.speed_mm_s,
                "Tool.PtMeasPar.Speed" => &mut settings.touch_mm_s,
                "Tool.ScanPar.Speed" => &mut settings.scan_mm_s,
                _ => return Err((Severity::Critical, 510, "Bad property")),
            };
            match property.numbers().as_deref() {
                Some([value]) if *value > 0.0 => *speed = *value,
                _ => return Err((Severity::Critical, 509, "Bad argument")),
            }
        }
        Ok(())
    }
}

fn info(call: &Call) -> Result<String, Failure> {
    let texts = [
        (6.0, "Transaction aborted (Use ClearAllErrors to Continue)"),
        (500.0, "Emergency stop"),
        (1006.0, "Surface not found"),
        (1008.0, "Target position out of machine volume"),
        (2504.0, "Collision"),
    ];
    let number = call.numbers().and_then(|numbers| numbers.first().copied());
    let known = texts.iter().find(|(known, _)| Some(*known) == number);
    let (_, text) = known.ok_or((Severity::Critical, 509, "Bad argument"))?;
    Ok(format!("\"{text}\""))
}

fn columns(call: &Call) -> Result<Vec<Column>, Failure> {
    let column = |argument: &Argument| match argument {
        Argument::Group(Call { name, arguments }) if arguments.is_empty() => match name.as_str() {
            "X" => Ok(Column::X),
            "Y" => Ok(Column::Y),
            "Z" => Ok(Column::Z),
            "Q" => Ok(Column::Q),
            "ER" => Ok(Column::Er),
            _ => Err((Severity::Critical, 510, "Bad property")),
        },
        _ => Err((Severity::Critical, 509, "Bad argument")),
    };
    call.arguments.iter().map(column).collect()
}
