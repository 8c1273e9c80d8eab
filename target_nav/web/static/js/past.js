// The strip of past ticks, and scrubbing in it: of this stack, or of a recording.

import { $, FONT, Pad, colors, h, setClass, setText } from "./dom.js";

const STATE_COLOR = { IDLE: "grey", NAVIGATING: "blue", SEARCHING: "orange", SPIRAL_SEARCH: "orange", BLIND_APPROACH: "red", ARRIVED: "green" };
const UNIT = 1 / 200;

export function mountPast(store, link) {
  const canvas = $("past");
  const pad = new Pad(canvas);
  let run = null; // {name, marks, path_m, bounds}
  let at = null; // number of the shown frame; null: live
  let asked = null;
  let busy = false;
  let playing = null;

  const marks = () => (run ? run.marks : store.marks);
  const windowS = () => Number($("past-window").value);

  function range() {
    const all = marks();
    if (!all.length) return [0, 1];
    const end = all[all.length - 1][1];
    const begin = all[0][1];
    const span = windowS() && !run ? windowS() : Math.max(end - begin, 1);
    return [run ? begin : end - span, run ? begin + span : end];
  }

  async function show(number) {
    const all = marks();
    if (!all.length) return;
    at = Math.min(Math.max(number, all[0][0]), all[all.length - 1][0]);
    asked = at;
    store.touch();
    if (busy) return;
    busy = true;
    try {
      while (asked !== null) {
        const wanted = asked;
        const of = run;
        asked = null;
        const answer = of ? { frame: await link.ask("run.frame", { run: of.name, number: wanted }), picture: "" } : await link.ask("past", { number: wanted });
        if (at === null || of !== run) return;
        let image = null;
        if (answer.picture) image = await createImageBitmap(await (await fetchData(answer.picture)));
        store.past = { sections: answer.frame, image, path_m: of?.path_m ?? null, bounds: of?.bounds };
        setClass(document.body, "past-shown", true);
        store.touch();
      }
    } catch (error) {
      setText($("past-says"), error.message);
    } finally {
      busy = false;
    }
  }

  function fetchData(base64) {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    return new Blob([bytes], { type: "image/jpeg" });
  }

  function live() {
    at = asked = null;
    run = null;
    store.past = null;
    $("past-source").value = "";
    stopPlaying();
    setClass(document.body, "past-shown", false);
    store.touch();
  }

  function markAt(clientX) {
    const all = marks();
    const box = canvas.getBoundingClientRect();
    const [begin, end] = range();
    const wanted = begin + ((clientX - box.left) / box.width) * (end - begin);
    let [low, high] = [0, all.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (all[middle][1] <= wanted) low = middle;
      else high = middle - 1;
    }
    return all[low]?.[0] ?? 0;
  }

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    stopPlaying();
    show(markAt(event.clientX));
  });
  canvas.addEventListener("pointermove", (event) => canvas.hasPointerCapture(event.pointerId) && show(markAt(event.clientX)));
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1, PageUp: -10, PageDown: 10 }[event.key];
    if (step) step_(step);
    else if (event.key === "Home") show(marks()[0]?.[0] ?? 0);
    else if (event.key === "End") (run ? show(marks().at(-1)[0]) : live());
    else return;
    event.preventDefault();
  });
  const newest = () => marks().at(-1)?.[0] ?? 0;
  const step_ = (step) => {
    stopPlaying();
    show((at ?? newest()) + step);
  };
  $("past-back").addEventListener("click", () => step_(-1));
  $("past-next").addEventListener("click", () => step_(1));
  $("past-live").addEventListener("click", live);
  $("past-play").addEventListener("click", () => (playing === null ? play() : stopPlaying()));
  $("past-window").addEventListener("change", () => store.touch());

  function play() {
    if (!marks().length) return;
    if (at === null || at >= newest()) show(Math.max(marks()[0][0], run ? 0 : newest() - 300));
    playing = setInterval(() => (at >= newest() ? (run ? stopPlaying() : live()) : show(at + 1)), 100);
    setText($("past-play"), "❚❚ pause");
  }
  function stopPlaying() {
    clearInterval(playing);
    playing = null;
    setText($("past-play"), "▶ play");
  }

  const source = $("past-source");
  let listed = null;
  async function listRuns() {
    const runs = await link.ask("runs");
    const names = runs.map((each) => each.name).join();
    // not under the hand of somebody who is choosing
    if (names === listed || document.activeElement === source) return;
    listed = names;
    source.replaceChildren(h("option", { value: "" }, "This stack"), ...runs.map((each) => h("option", { value: each.name }, `Recording ${each.name}`)));
    source.value = run?.name ?? "";
  }
  setInterval(() => link.open && !document.hidden && listRuns().catch(() => {}), 10000);
  source.addEventListener("change", async () => {
    const name = source.value;
    if (!name) return live();
    setText($("past-says"), `reading ${name} …`);
    try {
      const opened = await link.ask("run.open", { run: name });
      run = { name, ...opened, bounds: boundsOf(opened.path_m) };
      source.value = name;
      show(run.begin);
    } catch (error) {
      live();
      setText($("past-says"), error.message);
    }
  });
  link.addEventListener("welcome", () => {
    store.forget();
    listRuns().catch(() => {});
  });

  store.onDraw(() => {
    if (pad.width > 40) draw(pad, marks(), range(), at);
    const mark = at === null ? null : marks().find((each) => each[0] === at);
    const last = marks().at(-1);
    $("past-live").hidden = at === null;
    if (at !== null && last && mark) {
      const ago = last[1] - mark[1];
      setText($("past-says"), run ? `${mark[1].toFixed(1)} s of ${last[1].toFixed(1)} s · ${mark[3]}` : `${ago.toFixed(1)} s ago · ${mark[3]}`);
    } else if (at === null && last && !$("past-says").textContent.startsWith("reading")) {
      setText($("past-says"), `live · ${Math.round((last[1] - marks()[0][1]) / 6) / 10} min kept`);
    }
    canvas.setAttribute("aria-valuemin", marks()[0]?.[0] ?? 0);
    canvas.setAttribute("aria-valuemax", newest());
    canvas.setAttribute("aria-valuenow", at ?? newest());
    canvas.setAttribute("aria-valuetext", $("past-says").textContent);
  });
}

function boundsOf(flat) {
  const bounds = { x_min_m: 0, x_max_m: 0, y_min_m: 0, y_max_m: 0 };
  for (let i = 0; i + 1 < flat.length; i += 2) {
    bounds.x_min_m = Math.min(bounds.x_min_m, flat[i] * UNIT);
    bounds.x_max_m = Math.max(bounds.x_max_m, flat[i] * UNIT);
    bounds.y_min_m = Math.min(bounds.y_min_m, flat[i + 1] * UNIT);
    bounds.y_max_m = Math.max(bounds.y_max_m, flat[i + 1] * UNIT);
  }
  for (const name of Object.keys(bounds)) bounds[name] += name.includes("min") ? -0.6 : 0.6;
  return bounds;
}

function draw(pad, marks, [begin, end], at) {
  const context = pad.begin();
  const x = (time) => ((time - begin) / (end - begin)) * pad.width;
  const [top, height] = [20, Math.max(pad.height - 38, 12)];
  context.fillStyle = colors.raised;
  context.beginPath();
  context.roundRect(0, top, pad.width, height, 4);
  context.fill();
  context.font = `11.5px ${FONT}`;
  context.textBaseline = "middle";
  let first = 0;
  let textEnd = -1;
  for (let i = 0; i < marks.length; i++) {
    const last = i + 1 === marks.length || marks[i + 1][2] !== marks[first][2] || marks[i + 1][1] - marks[i][1] > 1;
    if (!last) continue;
    const [from, to] = [Math.max(x(marks[first][1]), 0), x(marks[i + 1]?.[1] - marks[i][1] < 1 ? marks[i + 1][1] : marks[i][1] + 0.1)];
    if (to > 0) {
      context.fillStyle = colors[STATE_COLOR[marks[first][2]] ?? "grey"];
      context.globalAlpha = marks[first][2] === "IDLE" ? 0.35 : 0.62;
      context.fillRect(from, top, Math.max(to - from, 1), height);
      context.globalAlpha = 1;
      const label = marks[first][2].replace("_", " ").toLowerCase();
      if (to - from > context.measureText(label).width + 10) {
        context.fillStyle = colors.text;
        context.fillText(label, from + 5, top + height / 2);
      }
    }
    first = i + 1;
  }
  // leaves that take over, above; what was stale, below
  let leaf = marks[0]?.[3];
  context.fillStyle = colors.dim;
  for (const mark of marks) {
    if (mark[3] === leaf) continue;
    leaf = mark[3];
    const u = x(mark[1]);
    if (u < 0) continue;
    context.fillRect(u, top - 4, 1, height + 4);
    if (u > textEnd && u < pad.width - 40) {
      context.fillText(leaf, u + 3, 9);
      textEnd = u + context.measureText(leaf).width + 12;
    }
  }
  context.fillStyle = colors.red;
  for (const mark of marks) if (mark[4]) context.fillRect(x(mark[1]), top + height + 2, Math.max((pad.width * 0.1) / (end - begin), 1), 3);
  context.fillStyle = colors.dim;
  const step = [1, 2, 5, 10, 30, 60, 120, 300].find((s) => (s / (end - begin)) * pad.width > 70) ?? 600;
  for (let t = 0; t < end - begin; t += step) {
    const u = x(end - t);
    context.fillText(t ? `-${t < 120 ? `${t} s` : `${t / 60} min`}` : "", Math.min(u + 3, pad.width - 34), pad.height - 7);
  }
  const cursor = at === null ? marks.at(-1) : marks.find((mark) => mark[0] === at);
  if (cursor) {
    context.fillStyle = at === null ? colors.text : colors.orange;
    context.fillRect(Math.min(x(cursor[1]), pad.width - 2) - 1, 2, 3, pad.height - 16);
  }
}
