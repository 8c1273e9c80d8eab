// Driving by hand: held is what moves. This page says so twenty times a second for as long as a finger or a key is
// down; whatever goes quiet on the way (this page, the network, the console) stops the robot by the nav process's deadman.

import { $, degrees, h, setClass, setText } from "./dom.js";

const PERIOD_MS = 50;
const FIELDS = [
  ["turn_left", "↺", "Q"], ["forward", "↑", "W"], ["turn_right", "↻", "E"],
  ["left", "←", "A"], null, ["right", "→", "D"],
  null, ["back", "↓", "S"], null,
];
const KEYS = {
  KeyW: "forward", ArrowUp: "forward", KeyS: "back", ArrowDown: "back", KeyA: "left", ArrowLeft: "left", KeyD: "right",
  ArrowRight: "right", KeyQ: "turn_left", PageUp: "turn_left", KeyE: "turn_right", PageDown: "turn_right",
};
const NAMES = { turn_left: "turn left", turn_right: "turn right", left: "strafe left", right: "strafe right", forward: "ahead", back: "back" };

export function mountDrive(store, link) {
  const held = new Map(); // holder (a pointer's or a key's name) to direction
  const buttons = new Map();
  let timer = null;
  let refused = "";
  let refusedAt = 0;

  const pad = h("div", { class: "pad", role: "group", "aria-label": "drive by hand; hold a field, or W A S D Q E while this is in focus", tabindex: "0" });
  for (const field of FIELDS) {
    if (!field) {
      pad.append(h("div", { class: "hub" }, pad.childElementCount === 4 ? "hold" : ""));
      continue;
    }
    const [direction, mark, key] = field;
    const button = h("button", { type: "button", "data-direction": direction, "aria-label": `hold to drive: ${NAMES[direction]}`, tabindex: "-1" }, mark, h("small", {}, key));
    buttons.set(direction, button);
    pad.append(button);
  }
  const says = { gap: h("div", { class: "gap" }), bar: h("div"), line: h("p"), title: h("p") };
  const meter = h("div", { class: "meter" }, says.bar);
  $("drive").append(pad, h("div", { class: "arrival" }, says.title, says.gap, meter, says.line));

  const directions = () => [...new Set(held.values())];
  function tell() {
    link.say({ t: "hold", at: performance.now(), held: directions() });
  }
  function changed() {
    for (const [direction, button] of buttons) setClass(button, "held", directions().includes(direction));
    tell();
    if (held.size && timer === null) timer = setInterval(tell, PERIOD_MS);
    if (!held.size && timer !== null) {
      clearInterval(timer);
      timer = null;
    }
  }
  function hold(holder, direction) {
    if (store.role !== "operator" || held.get(holder) === direction) return;
    held.set(holder, direction);
    changed();
  }
  function release(holder) {
    if (held.delete(holder)) changed();
  }
  function releaseAll() {
    if (!held.size) return;
    held.clear();
    changed();
  }

  pad.addEventListener("pointerdown", (event) => {
    const button = event.target.closest("button");
    if (!button || event.button > 0) return;
    pad.focus({ preventScroll: true });
    button.setPointerCapture(event.pointerId);
    hold(`pointer${event.pointerId}`, button.dataset.direction);
    event.preventDefault();
  });
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture"]) pad.addEventListener(kind, (event) => release(`pointer${event.pointerId}`));
  pad.addEventListener("contextmenu", (event) => event.preventDefault());
  pad.addEventListener("keydown", (event) => {
    const direction = KEYS[event.code];
    if (!direction || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (!event.repeat) hold(event.code, direction);
  });
  pad.addEventListener("keyup", (event) => release(event.code));
  // Whoever looks elsewhere does not drive.
  pad.addEventListener("focusout", (event) => {
    if (!pad.contains(event.relatedTarget)) releaseAll();
  });
  window.addEventListener("blur", releaseAll);
  window.addEventListener("pagehide", releaseAll);
  document.addEventListener("visibilitychange", () => document.hidden && releaseAll());
  link.addEventListener("lost", releaseAll);
  link.addEventListener("drive-refused", (event) => {
    [refused, refusedAt] = [event.detail, performance.now()];
    store.touch();
  });

  store.onDraw(({ live }) => {
    const operator = store.role === "operator";
    const status = live.status;
    for (const button of buttons.values()) if (button.disabled === operator) button.disabled = !operator;
    if (performance.now() - refusedAt > 3000) refused = "";
    const busy = status?.requested && !status.outcome ? "STOP first: a mission runs" : "";
    const text = !operator ? "only watching" : refused || live.drive?.problem || busy || (live.drive?.taken && !live.drive.mine ? "somebody else drives" : held.size ? directions().map((d) => NAMES[d]).join(", ") : "hold a field, or click and use W A S D");
    setText($("drive-says"), text);
    drawArrival(store.shown.arrival, says, meter);
  });
  return { releaseAll };
}

function drawArrival(view, says, meter) {
  if (!view) return;
  const known = view.gap_m !== null;
  setText(says.title, view.title || (known ? "to the target's surface" : "no target yet"));
  if (says.gap.dataset.shown !== String(view.gap_m)) {
    says.gap.dataset.shown = String(view.gap_m);
    says.gap.replaceChildren(known ? (view.gap_m < 1 ? (100 * view.gap_m).toFixed(1) : view.gap_m.toFixed(2)) : "-", h("small", {}, known ? (view.gap_m < 1 ? " cm" : " m") : ""));
  }
  says.bar.style.width = `${100 * view.progress}%`;
  setClass(meter, "done", view.succeeded);
  const sigma = view.sigma_m ? ` ± ${(100 * view.sigma_m).toFixed(1)} cm` : "";
  setText(says.line, known ? `stand-off ${(100 * view.stand_off_m).toFixed(0)} cm, bearing ${degrees(view.bearing_rad).toFixed(0)}°${sigma}` : "");
}
