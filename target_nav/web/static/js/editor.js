// Missions: a list of files and a text with the checker's messages at the line, as one types.

import { $, h, setText } from "./dom.js";
import { highlighted } from "./highlight.js";

const TYPING_MS = 350;
const LINE_PX = 20;
const PAD_PX = 8;

export function mountEditor(store, link) {
  const page = $("page-missions");
  const files = h("div", { class: "panel files", role: "list" });
  const name = h("b", {}, "no file open");
  const verdict = h("span", { class: "aside", role: "status" });
  const save = h("button", { type: "button", title: "Ctrl+S", disabled: true }, "Save");
  const force = h("button", { type: "button", class: "danger", hidden: true }, "Save with its errors");
  const saveAs = h("button", { type: "button", class: "quiet", disabled: true }, "Save as…");
  const load = h("button", { type: "button", disabled: true }, "Load on the robot");
  const area = h("textarea", { spellcheck: false, autocapitalize: "off", autocomplete: "off", wrap: "off", "aria-label": "mission file" });
  const pre = h("pre", { "aria-hidden": "true" });
  const marks = h("div", { "aria-hidden": "true" });
  const gutter = h("div", { class: "gutter", "aria-hidden": "true" });
  const code = h("div", { class: "code" }, h("div", { class: "code-sheet" }, gutter, h("div", { class: "text" }, marks, pre, area)));
  const list = h("ol", { class: "problems", "aria-label": "problems" });
  page.append(files, h("div", { class: "panel edit" }, h("div", { class: "edit-head" }, name, verdict, force, saveAs, save, load), code, list));

  let listing = { files: [], missions: [] };
  let open = null; // {name, text, version}
  let problems = [];
  let checked = null;
  let timer = null;
  let checking = false;
  let filesVersion = -1;

  const dirty = () => open !== null && area.value !== open.text;
  const operator = () => store.role === "operator";

  async function refresh() {
    listing = await link.ask("missions");
    files.replaceChildren(h("h2", {}, "Missions"), ...listing.files.map((each) =>
      h("button", { type: "button", role: "listitem", class: each.includes("/") ? "nested" : "", title: each, onclick: () => show(each), "aria-current": String(open?.name === each) }, each.split("/").at(-1))));
    // What the robot runs is what somebody most likely wants to see.
    const running = listing.files.find((each) => each.replace(/\.\w+$/, "") === store.live.status?.mission);
    if (!open && listing.files.length && !page.hidden) await show(running ?? listing.files[0]);
  }

  async function show(file) {
    if (dirty() && !confirm(`${open.name} has changes that are not saved. Leave them?`)) return;
    open = await link.ask("mission.read", { name: file });
    area.value = open.text;
    for (const button of files.querySelectorAll("button")) button.setAttribute("aria-current", String(button.title === file));
    setProblems([]);
    typed(true);
    code.scrollTo(0, 0);
  }

  function typed(now) {
    area.readOnly = !operator();
    paint();
    buttons();
    clearTimeout(timer);
    if (open && operator()) timer = setTimeout(check, now ? 0 : TYPING_MS);
  }

  async function check() {
    if (checking || !open) return;
    checking = true;
    const [file, text] = [open.name, area.value];
    setText(verdict, "checking …");
    try {
      const found = await link.ask("mission.check", { name: file, text });
      if (open?.name === file) {
        checked = text;
        setProblems(found);
      }
    } catch (error) {
      setText(verdict, error.message);
    } finally {
      checking = false;
      if (open && area.value !== text) timer = setTimeout(check, TYPING_MS);
    }
  }

  function setProblems(found) {
    problems = found;
    const count = (severity) => found.filter((each) => each.severity === severity).length;
    const [errors, warnings] = [count("error"), count("warning")];
    const words = [errors && `✘ ${errors} error${errors > 1 ? "s" : ""}`, warnings && `▲ ${warnings} warning${warnings > 1 ? "s" : ""}`].filter(Boolean);
    setText(verdict, words.join(", ") || (checked === null ? "" : "✔ nothing wrong"));
    list.replaceChildren(...found.map((each) => h("li", { class: each.severity },
      h("button", { type: "button", onclick: () => go(each) }, h("i", {}, each.severity === "error" ? "✘" : "▲"),
        h("span", {}, `${each.file === open?.name ? "line" : `${each.file}:`} ${each.line}`), each.message))));
    paint();
    buttons();
  }

  const errors = () => problems.some((each) => each.severity === "error");
  function buttons() {
    const may = operator() && open !== null && listing.writable !== false;
    save.disabled = !may || !dirty() || (errors() && checked === area.value);
    force.hidden = !(may && dirty() && errors() && checked === area.value);
    saveAs.disabled = !may;
    load.disabled = !operator() || !open || dirty() || !listing.missions.includes(open.name);
    setText(name, open ? `${open.name}${dirty() ? " •" : ""}` : "no file open");
  }

  function go(problem) {
    if (problem.file !== open?.name) {
      show(problem.file);
      return;
    }
    const lines = area.value.split("\n");
    const start = lines.slice(0, problem.line - 1).reduce((sum, line) => sum + line.length + 1, 0) + problem.column - 1;
    area.focus({ preventScroll: true });
    area.setSelectionRange(start, start);
    code.scrollTo({ top: Math.max(0, (problem.line - 4) * LINE_PX), behavior: "smooth" });
  }

  function paint() {
    const text = area.value;
    const lines = text.split("\n");
    const own = new Map();
    for (const each of problems) {
      if (each.file !== open?.name) continue;
      const before = own.get(each.line);
      if (!before || before.severity !== "error") own.set(each.line, each);
    }
    pre.replaceChildren(highlighted(text, open?.name.endsWith(".xml") ?? true), "\n");
    gutter.replaceChildren(...lines.map((_, i) => h("div", { class: own.get(i + 1)?.severity ?? "", title: own.get(i + 1)?.message ?? "" }, String(i + 1))));
    const width = lines.reduce((most, line) => Math.max(most, line.length), 0);
    marks.replaceChildren(...[...own].flatMap(([line, each]) => {
      const stripe = h("div", { class: `line-mark ${each.severity}` });
      stripe.style.top = `${PAD_PX + (line - 1) * LINE_PX}px`;
      const note = h("div", { class: `note ${each.severity}` }, each.message.length > 90 ? `${each.message.slice(0, 88)}…` : each.message);
      note.style.top = stripe.style.top;
      note.style.left = `calc(${Math.min((lines[line - 1] ?? "").length, width) + 3}ch + 10px)`;
      return [stripe, note];
    }));
  }

  async function keep(forced, as) {
    if (!open || !operator()) return;
    const text = area.value;
    try {
      const saved = await link.ask("mission.save", { name: as ?? open.name, text, version: as ? null : open.version, force: forced });
      open = saved;
      setText(verdict, `✔ saved ${saved.name}`);
      if (as) await refresh();
      buttons();
    } catch (error) {
      setText(verdict, error.message);
      clearTimeout(timer);
      timer = setTimeout(check, 1500);
    }
  }

  area.addEventListener("input", () => typed(false));
  area.addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key === "s") {
      event.preventDefault();
      if (!save.disabled) keep(false);
    }
    if (event.key === "Tab" && !event.shiftKey && !event.ctrlKey && !event.altKey && area.selectionStart !== area.selectionEnd) return;
    if (event.key === "Enter") {
      const before = area.value.slice(0, area.selectionStart).split("\n").at(-1);
      const indent = before.match(/^\s*/)[0];
      if (!indent) return;
      event.preventDefault();
      area.setRangeText(`\n${indent}`, area.selectionStart, area.selectionEnd, "end");
      typed(false);
    }
  });
  save.addEventListener("click", () => keep(false));
  force.addEventListener("click", () => confirm("Save this file with its errors? A robot cannot load it.") && keep(true));
  saveAs.addEventListener("click", () => {
    const as = prompt("Save under which name? (in the missions' folder)", open.name);
    if (as && as !== open.name) keep(false, as);
  });
  load.addEventListener("click", async () => {
    try {
      const said = await link.ask("load", { mission: open.name });
      setText(verdict, said.text);
    } catch (error) {
      setText(verdict, error.message);
    }
  });
  window.addEventListener("beforeunload", (event) => dirty() && event.preventDefault());

  store.onDraw(({ live }) => {
    const now = live.versions?.files;
    if (page.hidden || now === undefined || now === filesVersion) return;
    filesVersion = now;
    refresh().catch((error) => setText(verdict, error.message));
  });
  link.addEventListener("welcome", () => {
    filesVersion = -1;
    if (open) typed(true);
  });
}
