//! The scan that the station drives: orders of people, and what follows a pass.

use std::sync::Arc;

use asphera_link::Nanos;
use asphera_measure::RunningFigures;
use asphera_plan::{AdaptiveScan, Ending, Known, Polygon, Step, VerdictState, WantedRegion};
use asphera_report::{Outlook, PolygonFigures, ProspectState};
use tokio::task::JoinHandle;
use tracing::{error, info};

use super::super::brake::Halt;
use super::Core;
use crate::live::StationError;
use crate::session::What;
use crate::station::{ScanDecision, ScanOrder, ScanPlan, Scanner};

/// Decides what follows a pass.
#[derive(Default)]
pub(super) struct Decider {
    /// `None` while a decision is made, and without passes after the first.
    scan: Option<AdaptiveScan>,
    deciding: Option<JoinHandle<Option<Decided>>>,
}

/// A decision, and the scan that goes on from it.
pub(super) type Decided = (AdaptiveScan, ScanDecision);

impl Decider {
    pub(super) fn new(plan: Option<&ScanPlan>) -> Decider {
        Decider { scan: plan.and_then(ScanPlan::adaptive_scan), deciding: None }
    }
}

/// The decision after a pass, once one is being made; never before. `None`: there is none to be had.
pub(super) async fn decided(decider: &mut Decider) -> Option<Decided> {
    match &mut decider.deciding {
        Some(deciding) => deciding.await.ok().flatten(),
        None => std::future::pending().await,
    }
}

impl Core {
    /// Does what someone orders the scan.
    pub(super) async fn scan(&mut self, order: ScanOrder) -> Result<(), StationError> {
        let is_halt = order == ScanOrder::Halt;
        let is_measuring = self.session.as_ref().is_some_and(|session| session.ending.is_none());
        if !is_halt && !is_measuring {
            return Err(StationError::NotRunning);
        }
        info!(?order, "scan");
        let now = self.clock.now();
        // Of what was due before, nothing passes a brake that is pressed.
        self.bench.advance(now);
        self.settle(now).await;
        let result = self.order_scan(now, order).await;
        result.map_err(StationError::Arm)
    }

    async fn order_scan(
        &mut self,
        now: Nanos,
        order: ScanOrder,
    ) -> Result<(), crate::station::ArmError> {
        let result = self.bench.scan(now, &order);
        if order == ScanOrder::Halt {
            self.brake.release();
        }
        if result.is_ok() {
            self.record(now, What::Scan(order)).await;
        }
        // A link that opens, and a decision, end up here too.
        Box::pin(self.settle(now)).await;
        result
    }

    /// Tells the brake which connections are open.
    pub(super) fn connect_brake(&self) {
        let halts = self.bench.halts().into_iter().filter_map(|(line, epoch, bytes)| {
            Some(Halt { line, link: self.links.get(line)?.remote(), epoch, bytes })
        });
        self.brake.connect(halts.collect());
    }

    /// Has a decision made where the scanner waits for one.
    pub(super) fn ask_decision(&mut self) {
        let Some(scanner) = self.bench.scanner().filter(|scanner| scanner.wants_decision()) else {
            return;
        };
        let stands_mm = scanner.place_mm().unwrap_or_default();
        let spent_s = scanner.spent_s(self.bench.now());
        let Some(session) = self.session.as_ref().filter(|session| session.ending.is_none()) else {
            return;
        };
        let Decider { scan, deciding } = &mut self.decider;
        if deciding.is_some() {
            return;
        }
        let Some(mut scan) = scan.take() else { return };
        let assessed = session.worker.assess();
        *deciding = Some(tokio::spawn(async move {
            let figures = assessed.await?;
            let decide = move || {
                let decision = decide(&mut scan, &figures, stands_mm, spent_s);
                (scan, decision)
            };
            tokio::task::spawn_blocking(decide).await.ok()
        }));
    }

    /// A decision is there.
    pub(super) async fn decide(&mut self, decided: Option<Decided>) {
        self.decider.deciding = None;
        let order = match decided {
            Some((scan, decision)) => {
                self.decider.scan = Some(scan);
                ScanOrder::Decide(decision)
            }
            None => {
                error!("nothing could be decided after a pass");
                ScanOrder::Halt
            }
        };
        if self.session.as_ref().is_some_and(|session| session.ending.is_none()) {
            let now = self.clock.now();
            // Whatever comes of it stands in the state of the scan.
            let _ = self.order_scan(now, order).await;
        }
    }

    /// Ends a scan whose fail is certain, in the middle of a pass.
    pub(super) async fn end_certain_fail(&mut self) {
        let is_adaptive = self.bench.scanner().is_some_and(Scanner::ends_on_certain_fail);
        let Some(session) =
            self.session.as_ref().filter(|session| is_adaptive && session.ending.is_none())
        else {
            return;
        };
        let figures = session.worker.figures();
        if figures
            .is_some_and(|figures| verdict(figures.outlook.as_ref()) == VerdictState::FailCertain)
        {
            let now = self.clock.now();
            let _ = self
                .order_scan(now, ScanOrder::Decide(ScanDecision::End(Ending::FailCertain)))
                .await;
        }
    }
}

/// What follows a pass, by the figures of all points.
fn decide(
    scan: &mut AdaptiveScan,
    figures: &Arc<RunningFigures>,
    stands_mm: [f64; 2],
    spent_s: f64,
) -> ScanDecision {
    let regions: Vec<WantedRegion> = figures
        .sampling
        .next
        .iter()
        .map(|region| WantedRegion {
            polygons: region.polygons.iter().map(polygon).collect(),
            spacing_mm: region.spacing_needed_mm,
            gain: region.adds_coverage.unwrap_or(0.0),
        })
        .collect();
    let deviation = figures.form.as_ref().map(|form| &form.deviation);
    let known = Known {
        regions: &regions,
        coverage: figures.sampling.coverage,
        verdict: verdict(figures.outlook.as_ref()),
        u: deviation.and_then(|deviation| Some(deviation.uncertainty.as_ref()?.u_pv_nm)),
        spent_s,
        stands_mm,
    };
    match scan.next_step(&known) {
        Step::Measure(batch) => ScanDecision::measure(&batch),
        Step::End(ending) => ScanDecision::End(ending),
    }
}

/// State of the verdict: limits that are only known at the end are no reason to measure on.
fn verdict(outlook: Option<&Outlook>) -> VerdictState {
    let Some(outlook) = outlook.filter(|outlook| !outlook.limits.is_empty()) else {
        return VerdictState::NotAsked;
    };
    match outlook.state {
        ProspectState::FailCertain => VerdictState::FailCertain,
        ProspectState::PassCertain | ProspectState::AtEnd => VerdictState::PassCertain,
        ProspectState::PassFrom | ProspectState::Open => VerdictState::Open,
    }
}

fn polygon(figures: &PolygonFigures) -> Polygon {
    let ring = |places: &[[f64; 3]]| places.iter().map(|&[x, y, _]| [x, y]).collect();
    Polygon {
        outline_mm: ring(&figures.outline_mm),
        holes_mm: figures.holes_mm.iter().map(|hole| ring(hole)).collect(),
    }
}
