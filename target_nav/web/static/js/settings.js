// Every parameter by section, as the dataclasses describe it: unit, limits, help; live, or from the next start on.

import { $, h, setText } from "./dom.js";

const TITLES = { drive_sim: "drive (simulator)", ipc: "shared memory" };

export function mountSettings(store, link) {
  const page = $("page-settings");
  const index = h("div", { class: "panel files" });
  const search = h("input", { type: "search", placeholder: "Find a setting", "aria-label": "find a setting" });
  const waiting = h("span", { class: "aside", role: "status" });
  const body = h("div");
  const sheet = h("div", { class: "panel sheet" }, h("div", { class: "sheet-head" }, search, waiting), body);
  page.append(index, sheet);
  const rows = new Map();
  let version = -1;

  function build(data) {
    rows.clear();
    index.replaceChildren(h("h2", {}, "Settings"), ...data.sections.map((section) =>
      h("button", { type: "button", onclick: () => $(`section-${section.name}`).scrollIntoView({ behavior: "smooth" }) }, TITLES[section.name] ?? section.name)));
    body.replaceChildren(...data.sections.map((section) => h("section", { id: `section-${section.name}` },
      h("h3", {}, TITLES[section.name] ?? section.name), h("p", {}, section.help), ...section.settings.map(row))));
    fresh(data);
  }

  function row(setting) {
    const problem = h("p", { class: "problem", role: "alert" });
    const taken = h("span", { class: "taken" });
    const control = controlOf(setting, (value) => change(setting.key, value));
    const undo = h("button", { type: "button", class: "quiet", title: `back to ${setting.default}`, onclick: () => reset(setting.key) }, "↶");
    const title = h("span", {}, setting.name);
    const limits = setting.low === null ? "" : `${number(setting.low)} … ${number(setting.high)}`;
    const when = h("small", {}, setting.live ? h("span", { class: "live" }, "taken at once") : "from the next start on");
    const element = h("div", { class: "setting" }, h("div", { class: "name" }, title, when),
      h("div", { class: "value" }, control, h("span", {}, setting.unit), h("span", { class: "limits" }, limits), undo, taken),
      h("div", { class: "help" }, setting.help), problem);
    control.id = `set-${setting.key}`;
    control.setAttribute("aria-label", `${setting.key} ${setting.unit}`);
    rows.set(setting.key, { element, control, title, undo, problem, taken, setting });
    return element;
  }

  function fresh(data) {
    for (const section of data.sections) {
      for (const setting of section.settings) {
        const row = rows.get(setting.key);
        row.setting = setting;
        if (document.activeElement !== row.control) put(row.control, setting);
        row.title.className = setting.changed ? "changed" : "";
        row.undo.hidden = !setting.changed;
        row.control.disabled = row.undo.disabled = store.role !== "operator";
      }
    }
    const restart = data.waiting_for_restart;
    setText(waiting, restart.length ? `▲ waiting for the next start: ${restart.join(", ")}` : data.path ? `saved in ${data.path}` : "not saved: they last until the stack ends");
  }

  async function change(key, value) {
    const { problem, taken } = rows.get(key);
    setText(problem, "");
    try {
      const done = await link.ask("setting.change", { key, value });
      told(taken, done);
    } catch (error) {
      setText(problem, `✘ ${error.message}`);
    }
    await refresh();
  }

  async function reset(key) {
    const { problem, taken } = rows.get(key);
    setText(problem, "");
    try {
      told(taken, await link.ask("setting.reset", { key }));
    } catch (error) {
      setText(problem, `✘ ${error.message}`);
    }
    await refresh();
  }

  function told(node, done) {
    setText(node, !done.live ? "✔ from the next start on" : done.said?.acknowledged ? "✔ taken" : `▲ kept; ${done.said?.text ?? ""}`);
    setTimeout(() => setText(node, ""), 4000);
  }

  async function refresh() {
    const data = await link.ask("settings");
    if (rows.size) fresh(data);
    else build(data);
  }

  search.addEventListener("input", () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const { element, setting } of rows.values()) {
      const text = `${setting.key} ${setting.help} ${setting.unit}`.toLowerCase();
      element.hidden = !words.every((word) => text.includes(word));
    }
    for (const section of body.children) section.hidden = ![...section.querySelectorAll(".setting")].some((each) => !each.hidden);
  });

  store.onDraw(({ live }) => {
    const now = live.versions?.settings;
    if (page.hidden || now === undefined || now === version) return;
    version = now;
    refresh().catch((error) => setText(waiting, error.message));
  });
  link.addEventListener("welcome", () => (version = -1));
}

function number(value) {
  return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(6)));
}

function put(control, setting) {
  if (setting.kind === "switch") control.checked = setting.value;
  else control.value = typeof setting.value === "number" ? number(setting.value) : setting.value;
}

function controlOf(setting, change) {
  if (setting.kind === "choice") {
    return h("select", { onchange: (event) => change(event.target.value) }, ...setting.options.map((each) => h("option", { value: each }, each)));
  }
  if (setting.kind === "switch") return h("input", { type: "checkbox", onchange: (event) => change(event.target.checked) });
  if (setting.kind === "text") return h("input", { type: "text", onchange: (event) => change(event.target.value) });
  // the limits are the server's to check, so that its message tells them; a browser would only refuse
  return h("input", { type: "number", step: setting.kind === "whole" ? "1" : "any", inputmode: "decimal",
    onchange: (event) => change(event.target.value === "" ? null : Number(event.target.value)) });
}
