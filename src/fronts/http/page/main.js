// The page: one snapshot in, every part drawn.

import { showChapters } from "./chapters.js";
import { Contour } from "./contour.js";
import { Parts } from "./parts.js";
import { Control } from "./control.js";
import { Defects } from "./defects.js";
import { byId, setText } from "./dom.js";
import { DASH, count, duration, timeOfDay } from "./format.js";
import { Frames } from "./frames.js";
import { Histogram } from "./histogram.js";
import { Light } from "./light.js";
import { Links } from "./links.js";
import { PartMap } from "./map.js";
import { Maps } from "./maps.js";
import { Plots } from "./plots.js";
import { showProgress } from "./progress.js";
import { Regions } from "./regions.js";
import { Removal } from "./removal.js";
import { Scan } from "./scan.js";
import { SectionView } from "./section.js";
import { Sessions } from "./sessions.js";
import { Spectrum } from "./spectrum.js";
import { Stream } from "./stream.js";
import { takeToken } from "./token.js";
import { showVerdict } from "./verdict.js";
import { Volume } from "./volume.js";
import { Zernike } from "./zernike.js";

const root = document.documentElement;
const token = takeToken();
const control = new Control(token);
const sessions = new Sessions(token, (text, bad) => control.say(text, bad));
const scan = new Scan(token, (text, bad) => control.say(text, bad));
const links = new Links();
const regions = new Regions();
const defects = new Defects();
const contour = new Contour(token);
const parts = new Parts(token);
const map = new PartMap(regions, defects, contour, parts);
const maps = new Maps(token, (found) => map.setMaps(found));
const section = new SectionView(token, map);
const volume = new Volume(token);
const plots = new Plots();
const histogram = new Histogram();
const zernike = new Zernike();
const spectrum = new Spectrum();
const light = new Light();
const removal = new Removal(token, (view) => [map, histogram, zernike].forEach((shown) => shown.setView(view)));
const stream = new Stream(token, receive, showStream);
let link = { name: "connecting", why: "", since: null };
let newest = null;
let drawn = null;

regions.onChoice = () => map.draw();
contour.onChange = () => map.draw();
parts.onChange = () => map.draw();
defects.onChoice = (place) => {
  if (place) map.pointAt(place);
  map.draw();
};
const look = (layer) => maps.want(layer !== "deviation");
map.onLayer = look;
look(map.layer);

/** Snapshots may come faster than the screen is drawn: each frame draws the newest. */
function receive(snapshot) {
  if (newest === drawn) requestAnimationFrame(draw);
  newest = snapshot;
}

function draw() {
  drawn = newest;
  const snapshot = drawn;
  root.dataset.state = snapshot.state;
  root.dataset.sequence = snapshot.sequence;
  setText(byId("station"), snapshot.station);
  setText(byId("session"), snapshot.session?.id ?? DASH);
  showLabel(snapshot.session?.label);
  setText(byId("elapsed"), snapshot.session ? duration(snapshot.elapsed_s) : DASH);
  byId("skipped").hidden = stream.skipped === 0;
  setText(byId("skipped"), `skipped ${count(stream.skipped)}`);
  byId("skipped").title = "snapshots this page was too slow to show or missed while disconnected";
  showVerdict(snapshot);
  light.update(snapshot);
  removal.update(snapshot);
  regions.update(snapshot.sampling.next, Frames.of(snapshot));
  defects.update(snapshot, Frames.of(snapshot));
  contour.update(snapshot);
  parts.update(snapshot);
  map.update(snapshot);
  maps.update(snapshot);
  volume.update(snapshot);
  section.update(snapshot);
  showProgress(snapshot);
  plots.update(snapshot.convergence);
  histogram.update(snapshot.form);
  zernike.update(snapshot.form);
  spectrum.update(snapshot.form);
  links.update(snapshot);
  links.draw(link.name === "live");
  showChapters(snapshot.view);
  control.update(snapshot);
  scan.update(snapshot);
  sessions.update(snapshot);
}

function showLabel(label) {
  const what = [label?.part, label?.serial && `no. ${label.serial}`].filter(Boolean).join(", ");
  byId("part-shown").hidden = !what;
  setText(byId("part"), what);
  byId("operator-shown").hidden = !label?.operator;
  setText(byId("operator"), label?.operator ?? "");
}

function showStream(state) {
  link = state;
  root.dataset.stream = state.name;
  const words = { connecting: "connecting …", live: "live", stale: "not live" };
  setText(byId("stream-state"), words[state.name]);
  light.setStream(state);
  byId("stale-banner").hidden = state.name === "live" || !state.why;
  tick();
}

/** What goes on between snapshots: the ages and the time since the connection broke. */
function tick() {
  if (link.name !== "live" && link.why) {
    const since = link.since
      ? `Figures are of ${timeOfDay(link.since)}, ${duration((Date.now() - link.since) / 1000)} old.`
      : "Nothing was received yet.";
    setText(byId("stale-why"), `NOT LIVE: ${link.why}.`);
    setText(byId("stale-age"), since);
  }
  if (drawn) links.draw(link.name === "live");
  light.draw();
}

setInterval(tick, 500);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  map.draw();
  plots.recolour();
  histogram.recolour();
  zernike.recolour();
  spectrum.recolour();
  section.recolour();
  volume.draw();
});
stream.start();
