//! Insertion of a whole run of points that lies outside the hull, as the next line of a scan does.
//!
//! Point by point, each would tear down what the one before it built towards the rest of the last
//! line. Here the strip between the hull and the run is filled at once, as two lines are sewn
//! together, and then made Delaunay by flips, of which few are needed:
//!
//! ```text
//!        c0 ── c1 ── c2 ── c3 ── c4      the hull, its inside above
//!         \   / \   /\    / \   / \
//!          p0 ── p1 ── p2 ── p3 ── …     the run, in the sense of the hull
//! ```
//!
//! This is the merge step of L. Guibas and J. Stolfi, Primitives for the manipulation of general
//! subdivisions, ACM Trans. Graph. 4 (1985) 74-123, doi:10.1145/282918.282923, for a set that is a
//! mere line, with the repair left to Lawson's flips.
//!
//! **Why the result is right.** From any triangulation of a convex region flips lead to the Delaunay
//! triangulation, so nothing needs to be shown but that the triangles do not overlap and leave nothing
//! open. Where one of the conditions does not hold the plan is given up before anything is changed,
//! and the points are inserted one by one.
//!
//! - *Within the strip.* Both lines advance strictly along one axis, which doubles tell exactly, and every
//!   new triangle turns counter-clockwise. A line across the axis meets the closed line around the
//!   strip at most twice, so it winds at most once about any place.
//! - *With what stands.* Triangles make way only so that the line of the hull still advances along the
//!   axis: within its span the strip lies outside it. Beyond its end the run may only go if no side of
//!   the hull that leads on was before it and left (`owed`), and none that came to light
//!   (`Plan::ends`); a side that was never before the run meets the last one in a convex corner, and
//!   behind that the run does not reach it. At the start the run begins before the hull's line only
//!   where that is the outermost along the axis.
//! - *Beside an unfinished line* the fan that closed the hull is opened first (`fan.rs`), which leaves one
//!   corner of the hull that is not convex. The whole run lies before the line at that corner, so the strip
//!   does not end there but where the rest of the line lies ahead of the run along the axis; that is
//!   closed with the corners.
//! - *With the hull.* The new line of the hull advances along the axis too, so that closing its corners
//!   fills empty ears. The corners at its two ends are closed on the ring of ghosts, after all else is
//!   in place, because that may lead all around (`hull.rs`).
//! - *Cells.* A strip of k points takes 2k cells more than make way, and those that make way come first.

use asphera_geometry::VertexId;
use asphera_geometry::predicates::{Place, encloses, left_of};

use super::cells::{Cells, GHOST, Side, Slot};
use super::editor::Editor;
use super::fan::Out;
use super::places::Places;
use super::runs::{Axis, Track};

/// A run of points in the sense of the hull.
#[derive(Clone, Copy)]
struct Path {
    run: Track,
    backwards: bool,
}

impl Path {
    #[inline(always)]
    fn at(self, index: usize) -> VertexId {
        self.run.at(if self.backwards { self.run.count - 1 - index } else { index }) as VertexId
    }
}

/// How the strip is to be filled, and memory for doing so.
#[derive(Default)]
pub(super) struct Plan {
    /// One for each triangle of the strip.
    steps: Vec<Step>,
    /// How many of them are on a side of the hull.
    of_hull: usize,
    /// Triangles and ghosts that make way.
    freed: Vec<Slot>,
    /// Sides of the hull after those triangles went, still to be passed, the next one last.
    chain: Vec<Side>,
    /// Such sides before and behind the run, which bound the hull again.
    before: Vec<Side>,
    after: Vec<Side>,
    /// Old sides that were not found Delaunay.
    doubtful: Vec<Side>,
    /// The ghost before the next side of the old hull.
    ghost: Slot,
    /// How many triangles made way only because they were in the way.
    dug: usize,
    /// How many of the freed are ghosts.
    ghosts_passed: usize,
    /// A triangle at each point, in the order of arrival.
    slots: Vec<Slot>,
    /// Ghosts at the start and at the end of the last strip.
    ends: [Slot; 2],
    /// How many runs more are inserted point by point, as the last strips took many flips.
    left_alone: u32,
    /// How many that were the last time.
    setback: u32,
    /// How many times as many points as at first the next strip may have.
    trust: u32,
    /// The side between the hull and the middle of the run: at the ends of a line it may lead along the side of the mesh.
    bridge: [Place; 2],
    /// Whether that of the last strip was long.
    is_wide: bool,
    /// The hull after the strip: vertices, and the triangle's side that ends at each.
    hull: Vec<(VertexId, Side)>,
}

/// A triangle of the strip: on a side of the run, or on an old side, seen from inside.
#[derive(Clone, Copy)]
enum Step {
    Run,
    Hull(Side),
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// Inserts the points `run`, which advance along `axis`, if they lie outside the hull, or in what
    /// merely closes it, and nothing stands in the way of a strip; otherwise changes nothing.
    ///
    /// `from` is a triangle near the first point. True if they are inserted; then
    /// [`Editor::strip_slots`] has a triangle at each.
    pub(super) fn insert_strip(&mut self, run: Track, axis: Axis, from: Slot) -> bool {
        let Some(ghost) = self.hull_near(run, from) else { return false };
        let [start, end] = [1, 0].map(|index| axis.along(self.at(self.cells.corner(ghost, index))));
        let (axis, backwards) = if start < end { (axis, false) } else { (axis.reversed(), true) };
        let path = Path { run, backwards };
        let Some(ghost) = self.hull_side_at(self.at(path.at(0)), axis, ghost) else { return false };
        let edge = ghost;
        let unfolded = if backwards {
            self.unfold(edge, axis.reversed(), Out::Back, run)
        } else {
            self.unfold(edge, axis, Out::Ahead, run)
        };
        let ghost = self.hull_side_at(self.at(path.at(0)), axis, edge);
        let mut plan = std::mem::take(&mut self.work.strip);
        let planned = match ghost {
            Some(ghost)
                if self.plan(&mut plan, path, axis, ghost)
                    && plan.is_sewn()
                    && !self.is_mismatched(&mut plan, path) =>
            {
                self.sew(&mut plan, path, ghost);
                if backwards {
                    plan.slots.reverse();
                }
                true
            }
            _ => {
                if unfolded {
                    let before = self.cells.across(Side::new(edge, 0)).slot();
                    self.close_corner(if backwards { before } else { edge });
                }
                false
            }
        };
        self.work.strip = plan;
        let flips = self.legalize();
        if planned {
            self.work.strip.note_flips(flips, run.count);
        }
        planned
    }

    /// Whether a strip does not match the hull before it: flips may then be as many as pairs of a point and a side.
    ///
    /// That is so between lines that lie apart by many times their steps and are not straight. Of shorter strips it shows when the first
    /// ones were made, but not where the hull before them is long: 1,000 points before 11,000 sides took 9.5 million.
    fn is_mismatched(&self, plan: &mut Plan, path: Path) -> bool {
        let points = path.run.count;
        let [first, last] = [0, points - 1].map(|index| self.at(path.at(index)));
        let distance = |[p, q]: [Place; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
        let step = distance([first, last]) / points as f64;
        plan.is_wide = distance(plan.bridge) > WIDE_STEPS * step;
        let sides_a_point = if plan.is_wide { UNEVEN } else { LOPSIDED };
        let sees_much = plan.of_hull > LONG_HULL.max(sides_a_point * points);
        let sees_little = points > SHORT && EVEN[0] * points > EVEN[1] * plan.of_hull;
        sees_much || plan.is_wide && (points >= 2 * LONGEST_WIDE || sees_little)
    }

    /// How many of so many points that follow one another are to be tried as a strip next: none where the last ones took
    /// many flips, and few at first.
    pub(super) fn next_strip(&mut self, points: usize) -> usize {
        let plan = &mut self.work.strip;
        if plan.left_alone > 0 {
            plan.left_alone -= 1;
            return 0;
        }
        let most =
            (FIRST_STRIP << plan.trust).min(if plan.is_wide { LONGEST_WIDE } else { usize::MAX });
        if points < 2 * most { points } else { most }
    }

    /// Takes note that another line of so many points starts, where lines arrived by turns. Of a long one few points are
    /// tried first: a strip that sees all of the line beside it would take thousands of flips a point.
    pub(super) fn start_line(&mut self, points: usize) {
        if points > LONG_LINE {
            self.work.strip.trust = 0;
        }
    }

    /// A ghost near a point: the one before which it lies or, inside the hull, one at the end of the
    /// strip that the point's run continues, if it does.
    fn hull_near(&self, run: Track, from: Slot) -> Option<Slot> {
        let place = self.at(run.at(0) as VertexId);
        // Where vertices were removed since, cells may be unused that were ghosts then. Those of the
        // last triangles lead nowhere.
        let is_ghost = |slot: Slot| {
            let [end, _, last] = self.cells.corners(slot);
            last == GHOST && end != GHOST
        };
        // A walk from the last strip's end would lead through the whole fan beside it.
        let ends = self.work.strip.ends.into_iter();
        let ahead = ends.filter(|&end| is_ghost(end)).find(|&end| self.in_conflict(end, place));
        if ahead.is_some() {
            return ahead;
        }
        let home = self.locate(place, from);
        if self.cells.is_ghost(home) {
            return Some(home);
        }
        let next = self.at(run.at(1) as VertexId);
        let step = (next[0] - place[0]).hypot(next[1] - place[1]);
        let is_near = |ghost: Slot| {
            let [end, start, _] = self.cells.corners(ghost);
            is_ghost(ghost) && distance_mm(self.at(start), self.at(end), place) < NEAR_STEPS * step
        };
        let next = |ghost: Slot| self.cells.across(Side::new(ghost, 1)).slot();
        let known = self.work.strip.ends.into_iter().filter(|&ghost| is_ghost(ghost));
        known.flat_map(|ghost| [ghost, next(ghost)]).find(|&ghost| is_near(ghost))
    }

    /// A triangle that was made at each point of the last strip.
    pub(super) fn strip_slots(&self) -> &[Slot] {
        &self.work.strip.slots
    }

    /// The ghost before that side of the hull over which `place` lies, seen across `axis`, or the
    /// outermost of those sides that lead along the axis.
    fn hull_side_at(&self, place: Place, axis: Axis, from: Slot) -> Option<Slot> {
        let target = axis.along(place);
        let mut ghost = from;
        loop {
            let [start, end] = [1, 0].map(|i| axis.along(self.at(self.cells.corner(ghost, i))));
            if end <= start {
                return None;
            }
            let beyond = if start > target {
                let before = self.cells.across(Side::new(ghost, 0)).slot();
                (axis.along(self.at(self.cells.corner(before, 1))) < start).then_some(before)
            } else if end <= target {
                let after = self.cells.across(Side::new(ghost, 1)).slot();
                (axis.along(self.at(self.cells.corner(after, 0))) > end).then_some(after)
            } else {
                None
            };
            match beyond {
                Some(beyond) => ghost = beyond,
                None => return Some(ghost),
            }
        }
    }

    /// Decides on the triangles between the run and the hull from `ghost` on. False if there is
    /// no way.
    fn plan(&self, plan: &mut Plan, path: Path, axis: Axis, ghost: Slot) -> bool {
        plan.restart(ghost);
        let (mut on_hull, mut on_run) = (self.at(self.cells.corner(ghost, 1)), self.at(path.at(0)));
        let mut passed = 1;
        let mut side = self.next_side(plan, axis, on_hull);
        // What lies before the run comes to light where triangles made way, and bounds the hull again.
        while let Some(next) = &mut side {
            self.clear(plan, axis, on_hull, on_run, next);
            let inner = next.inner;
            let end = self.at(self.cells.end(inner));
            if next.of_ghost || axis.along(end) > axis.along(on_run) {
                break;
            }
            plan.before.push(inner);
            on_hull = end;
            side = self.next_side(plan, axis, on_hull);
        }
        // Whether the run went on although the hull's next side lay before it.
        let mut owed = false;
        loop {
            // What is left of a straight line is closed with the corners of the hull.
            if let Some(NextSide { of_ghost: true, .. }) = side
                && passed == path.run.count
                && matches!(plan.steps.last(), Some(Step::Hull(_)))
                && self.begins_fan(plan.ghost, axis, on_run)
            {
                return plan.ends(side, true);
            }
            // Places are read where they are needed: in an Option they would go through memory in halves.
            let hull_is_next = match &mut side {
                Some(side) => self.clear(plan, axis, on_hull, on_run, side),
                None => false,
            };
            let run_is_next = passed < path.run.count && {
                let on = self.at(path.at(passed));
                let turns = left_of(on_hull, on_run, on);
                if !hull_is_next && !turns {
                    return false;
                }
                turns
                    && match side {
                        Some(side) if hull_is_next => {
                            let end = self.at(self.cells.end(side.inner));
                            encloses(on_hull, on_run, end, on)
                        }
                        _ => true,
                    }
            };
            if run_is_next {
                plan.steps.push(Step::Run);
                on_run = self.at(path.at(passed));
                passed += 1;
                owed |= hull_is_next;
                if passed == path.run.count / 2 {
                    plan.bridge = [on_hull, on_run];
                }
            } else if let Some(NextSide { inner, of_ghost }) = side
                && hull_is_next
            {
                plan.steps.push(Step::Hull(inner));
                plan.of_hull += 1;
                if of_ghost {
                    self.pass_ghost(plan);
                }
                on_hull = self.at(self.cells.end(inner));
                owed = false;
                side = self.next_side(plan, axis, on_hull);
            } else {
                let behind = axis.along(on_hull) >= axis.along(on_run);
                return (behind || !owed) && plan.ends(side, behind);
            }
        }
    }

    /// The next side of the hull: one that a triangle left which made way, or one of the old hull
    /// as long as those lead along the axis.
    fn next_side(&self, plan: &mut Plan, axis: Axis, on_hull: Place) -> Option<NextSide> {
        if let Some(inner) = plan.chain.pop() {
            return Some(NextSide { inner, of_ghost: false });
        }
        let end = self.at(self.cells.corner(plan.ghost, 0));
        let inner = self.cells.across(Side::new(plan.ghost, 2));
        (axis.along(on_hull) < axis.along(end)).then_some(NextSide { inner, of_ghost: true })
    }

    /// Whether `on_run` lies before the side, that is outside.
    ///
    /// Triangles of which that place is inside the circumcircle make way first, and those behind which it
    /// lies, as they close the hull beside an unfinished line; the side becomes the first of those
    /// they leave. Not so where the line would not advance along the axis then.
    #[inline(always)]
    fn clear(
        &self,
        plan: &mut Plan,
        axis: Axis,
        on_hull: Place,
        on_run: Place,
        side: &mut NextSide,
    ) -> bool {
        loop {
            let inner = side.inner;
            let end = self.at(self.cells.end(inner));
            let before = left_of(end, on_hull, on_run);
            // Behind a mesh of a single row lies a ghost.
            if self.cells.is_ghost(inner.slot()) {
                return before;
            }
            let [a, b, c] = self.cells.corners(inner.slot()).map(|corner| self.at(corner));
            if before && !encloses(a, b, c, on_run) {
                return before;
            }
            if !self.make_way(plan, axis, [on_hull, on_run, end], side) {
                return before;
            }
        }
    }

    /// Takes the triangle behind the side out, unless the line would not advance along the axis then,
    /// or the place is neither before the side nor straight behind it.
    #[inline(never)]
    fn make_way(
        &self,
        plan: &mut Plan,
        axis: Axis,
        [on_hull, on_run, end]: [Place; 3],
        side: &mut NextSide,
    ) -> bool {
        let inner = side.inner;
        let is_before = left_of(end, on_hull, on_run);
        if !is_before && (!axis.is_between(on_hull, on_run, end) || !plan.may_dig()) {
            return false;
        }
        if !axis.is_between(on_hull, self.at(self.cells.apex(inner)), end) {
            plan.doubtful.extend(is_before.then_some(inner));
            return false;
        }
        let (to_apex, to_end) = (self.cells.across(inner.prev()), self.cells.across(inner.next()));
        if side.of_ghost {
            self.pass_ghost(plan);
        }
        plan.freed.push(inner.slot());
        plan.chain.push(to_end);
        *side = NextSide { inner: to_apex, of_ghost: false };
        true
    }

    fn pass_ghost(&self, plan: &mut Plan) {
        plan.freed.push(plan.ghost);
        plan.ghosts_passed += 1;
        plan.ghost = self.cells.across(Side::new(plan.ghost, 1)).slot();
    }

    /// Carries out the plan: the strip that starts at `ghost`, and the hull about it.
    fn sew(&mut self, plan: &mut Plan, path: Path, ghost: Slot) {
        let ghost_before = self.cells.across(Side::new(ghost, 0)).slot();
        let mut tip = self.cells.corner(ghost, 1);
        let mut hull = std::mem::take(&mut plan.hull);
        hull.clear();
        hull.push((tip, Side::NONE));
        self.work.ghosts -= plan.ghosts_passed;
        self.work.spare.append(&mut plan.freed);
        for inner in plan.before.drain(..) {
            tip = self.cells.end(inner);
            self.close(&mut hull, tip, inner);
        }
        plan.slots.clear();
        self.work.suspects.append(&mut plan.doubtful);
        // The open side of the last triangle, from the run to the hull.
        let mut bridge = Side::NONE;
        let mut passed = 0;
        for step in plan.steps.drain(..) {
            let slot = self.take_spare();
            let here = path.at(passed);
            let to_here = Side::new(slot, 2);
            if bridge != Side::NONE {
                self.cells.set_across(bridge, to_here);
                self.work.suspects.push(to_here);
            }
            match step {
                Step::Run => {
                    let next = path.at(passed + 1);
                    self.cells.write(slot, [tip, here, next], [Side::NONE, Side::NONE, bridge]);
                    if bridge == Side::NONE {
                        self.close(&mut hull, here, to_here);
                    }
                    self.close(&mut hull, next, Side::new(slot, 0));
                    bridge = Side::new(slot, 1);
                    plan.slots.push(slot);
                    passed += 1;
                }
                Step::Hull(inner) => {
                    let end = self.cells.end(inner);
                    self.cells.write(slot, [tip, here, end], [Side::NONE, inner, bridge]);
                    self.cells.set_across(inner, Side::new(slot, 1));
                    if bridge == Side::NONE {
                        self.close(&mut hull, here, to_here);
                    }
                    bridge = Side::new(slot, 0);
                    tip = end;
                }
            }
        }
        plan.slots.push(bridge.slot());
        self.close(&mut hull, tip, bridge);
        for inner in plan.after.drain(..) {
            self.close(&mut hull, self.cells.end(inner), inner);
        }
        let last = self.write_ghosts(&hull, ghost_before, plan.ghost);
        plan.hull = hull;
        plan.ends = [ghost_before, last].map(|ghost| self.close_corner(ghost));
    }

    /// Takes a vertex that follows on the hull; the triangle inside has the side `inner` that ends there.
    /// Where the hull turns right, triangles fill it.
    ///
    /// ```text
    ///                inner of the corner
    ///      before ──────▶ corner
    ///             \        │            before, next and corner make a triangle
    ///               \      ▼ inner
    ///                 ──▶ next
    /// ```
    #[inline]
    fn close(&mut self, hull: &mut Vec<(VertexId, Side)>, next: VertexId, mut inner: Side) {
        while let [.., (before, _), (corner, before_side)] = hull[..]
            && left_of(self.at(corner), self.at(before), self.at(next))
        {
            let slot = self.take_spare();
            self.cells.write(slot, [before, next, corner], [inner, before_side, Side::NONE]);
            let sides = [0, 1, 2].map(|i| Side::new(slot, i));
            self.cells.set_across(inner, sides[0]);
            self.cells.set_across(before_side, sides[1]);
            self.work.suspects.extend([sides[0], sides[1]]);
            hull.pop();
            inner = sides[2];
        }
        hull.push((next, inner));
    }

    /// Puts ghosts before all sides of the new hull, from the ghost `before` it to the one `after` it;
    /// returns the last.
    fn write_ghosts(&mut self, hull: &[(VertexId, Side)], before: Slot, after: Slot) -> Slot {
        self.work.ghosts += hull.len() - 1;
        let (mut last, mut start) = (before, hull[0].0);
        for &(end, inner) in &hull[1..] {
            let ghost = self.take_spare();
            self.cells.write(ghost, [end, start, GHOST], [Side::new(last, 1), Side::NONE, inner]);
            self.cells.set_across(Side::new(last, 1), Side::new(ghost, 0));
            self.cells.set_across(inner, Side::new(ghost, 2));
            (last, start) = (ghost, end);
        }
        self.cells.join(Side::new(last, 1), Side::new(after, 0));
        last
    }

    fn take_spare(&mut self) -> Slot {
        self.work.spare.pop().expect("two cells are kept for each point to come")
    }
}

/// How far a place lies from a side.
fn distance_mm(start: Place, end: Place, place: Place) -> f64 {
    let [along, off] = [end, place].map(|place| [place[0] - start[0], place[1] - start[1]]);
    let share = (along[0] * off[0] + along[1] * off[1])
        / (along[0] * along[0] + along[1] * along[1]).max(f64::MIN_POSITIVE);
    let share = share.clamp(0.0, 1.0);
    (off[0] - share * along[0]).hypot(off[1] - share * along[1])
}

/// A run continues a strip from which it is no farther than so many of its steps.
const NEAR_STEPS: f64 = 4.0;

/// More flips a point are too many. A raster with 5 % jitter takes a third of one, lines at random places one or two.
const MOST_FLIPS: usize = 8;

/// More triangles for each side of the hull are fans.
const FAN: usize = 16;

/// A strip is wide from so many steps of its run on.
const WIDE_STEPS: f64 = 64.0;

/// Points of a wide strip at most, or twice as many where those are all there are.
const LONGEST_WIDE: usize = 1024;

/// A strip may have so many sides of the hull before it, or so many for each of its points: fewer where it is wide. 64 points before
/// 25,600 sides took 1.6 million flips.
const LONG_HULL: usize = 5000;
const UNEVEN: usize = 2;
const LOPSIDED: usize = 64;

/// A wide strip of more points than these may have no more than 5 for each 4 sides before it: 1,024 points before 750 sides took
/// a million flips.
const SHORT: usize = 256;
const EVEN: [usize; 2] = [4, 5];

/// Points of the first strip, each next one being four times as long as long as flips are few.
const FIRST_STRIP: usize = 64;
const LONG_LINE: usize = 8 * FIRST_STRIP;
const MOST_TRUST: u32 = 24;

/// How many runs are inserted point by point at most before a strip is tried again.
const LONGEST_SETBACK: u32 = 127;

/// A side of the hull before the run, seen from inside.
#[derive(Clone, Copy)]
struct NextSide {
    inner: Side,
    /// Whether it is a side of the old hull, before `Plan::ghost`.
    of_ghost: bool,
}

impl Plan {
    /// Takes note of how many flips a run took. Along an outline that is traced sides are long and turn about far
    /// points: flips then are many times as many as triangles differ in the end, and insertion by bisection is
    /// cheaper. More and more runs are spared the trial as long as that is so, and each trial is of few points.
    fn note_flips(&mut self, flips: usize, points: usize) {
        if flips > MOST_FLIPS * (points + MOST_FLIPS) {
            self.setback = (2 * self.setback + 1).min(LONGEST_SETBACK);
            self.left_alone = self.setback;
            self.trust = 0;
        } else {
            self.setback = 0;
            self.trust = (self.trust + 2).min(MOST_TRUST);
        }
    }

    /// Whether the run is sewn to a line of about as many points. A run about a few far points makes a fan at each, of which
    /// flips leave next to nothing.
    fn is_sewn(&self) -> bool {
        self.steps.len() < FAN * (self.of_hull + FAN)
    }

    /// Whether the strip can end before `side`. What is left of the sides that came to light must lie
    /// behind the run, to bound the hull again: else it would be left open.
    fn ends(&mut self, side: Option<NextSide>, behind: bool) -> bool {
        let left = side.filter(|side| !side.of_ghost).map(|side| side.inner);
        self.after.extend(left);
        self.after.extend(self.chain.drain(..).rev());
        (behind || self.after.is_empty())
            && self.steps.iter().any(|step| matches!(step, Step::Hull(_)))
    }

    /// Whether one triangle more may make way only because it is in the way. A run that leads into the
    /// mesh is not for a strip.
    fn may_dig(&mut self) -> bool {
        self.dug += 1;
        self.dug < 4 * self.steps.len() + 256
    }

    fn restart(&mut self, ghost: Slot) {
        self.dug = 0;
        self.of_hull = 0;
        self.ghost = ghost;
        self.ghosts_passed = 0;
        self.steps.clear();
        self.freed.clear();
        self.chain.clear();
        self.doubtful.clear();
        self.before.clear();
        self.after.clear();
    }
}
