// GO, STOP and the other words, and what came of the last one. STOP works from everywhere, by Space and by Escape.

import { $, h, setClass, setText } from "./dom.js";

const LATE_MS = 250; // the server waits 100 ms for the nav process; the rest is the way there and back

export function mountWords(store, link, driving) {
  const said = $("said");
  let pending = null; // {word, since}
  let lastKey = "";
  let lastSaidAt = 0;

  function show(text, level) {
    setText(said, text);
    setClass(said, "good", level === "good");
    setClass(said, "bad", level === "bad");
  }

  async function say(what, args = {}) {
    const word = what.replace("_", " ").toUpperCase();
    pending = { word };
    const late = setTimeout(() => show(`${word} NOT ACKNOWLEDGED`, "bad"), LATE_MS);
    try {
      const answer = await link.ask(what, args);
      lastSaidAt = answer.at_s;
      show(answer.text, answer.acknowledged ? "good" : "bad");
      return answer;
    } catch (error) {
      show(`${word} NOT SENT: ${error.message}`, "bad");
      return null;
    } finally {
      clearTimeout(late);
      pending = null;
    }
  }

  function stop() {
    driving.releaseAll();
    if (store.role !== "operator") {
      show("STOP needs the operator's address", "bad");
      return;
    }
    say("stop");
  }

  $("go").addEventListener("click", () => say("go"));
  $("stop").addEventListener("click", stop);
  $("pause").addEventListener("click", () => say(store.live.status?.paused ? "resume" : "pause"));
  $("step").addEventListener("click", () => say("step"));
  $("reset-odometry").addEventListener("click", () => say("reset_odometry"));

  // Before anything else on the page: a focused button must not take Space for itself.
  window.addEventListener("keydown", (event) => {
    const space = event.code === "Space" && !isTextField(event.target);
    if (event.repeat || (!space && event.key !== "Escape") || $("token-dialog").open) return;
    event.preventDefault();
    event.stopPropagation();
    stop();
  }, { capture: true });
  window.addEventListener("keyup", (event) => {
    if (event.code === "Space" && !isTextField(event.target)) event.preventDefault();
  }, { capture: true });

  const mission = $("mission-choice");
  const target = $("target-choice");
  mission.addEventListener("change", async () => {
    if (mission.value) await say("load", { mission: mission.value });
    mission.value = "";
  });
  target.addEventListener("change", async () => {
    const spec = target.value ? JSON.parse(target.value) : {};
    await say("target", spec.class_name ? { class: spec.class_name, height_m: spec.height_m, width_m: spec.width_m, lidar_width_m: spec.lidar_width_m } : {});
  });

  async function fill() {
    const { missions, targets } = await link.ask("missions");
    mission.replaceChildren(h("option", { value: "" }, "choose…"), ...missions.map((name) => h("option", { value: name }, name.replace(/\.\w+$/, ""))));
    target.replaceChildren(h("option", { value: "" }, "the mission's"), ...targets.map((spec) =>
      h("option", { value: JSON.stringify(spec) }, `${spec.class_name.replaceAll("_", " ")}, ${Math.round(100 * spec.height_m)} cm`)));
  }
  let files = -1;

  store.onDraw(({ live }) => {
    const operator = store.role === "operator" && link.open;
    for (const id of ["go", "pause", "step", "reset-odometry", "mission-choice", "target-choice"]) if ($(id).disabled === operator) $(id).disabled = !operator;
    setText($("pause"), live.status?.paused ? "Resume" : "Pause");
    setText(mission.options[0] ?? mission, live.status?.mission || "choose…");
    const now = live.versions?.files;
    if (now !== undefined && now !== files) {
      files = now;
      fill().catch(() => (files = -1));
    }
    // A word of another page, or a late answer to one of ours.
    const last = live.said;
    const key = last && `${last.at_s} ${last.text}`;
    if (last && !pending && key !== lastKey && last.at_s >= lastSaidAt) {
      [lastKey, lastSaidAt] = [key, last.at_s];
      show(last.text, last.acknowledged ? "good" : last.late ? "bad" : "");
    }
  });
}

export function isTextField(node) {
  if (!(node instanceof HTMLElement)) return false;
  return node.isContentEditable || node.tagName === "TEXTAREA" || (node.tagName === "INPUT" && !["checkbox", "radio", "button", "range"].includes(node.type));
}
