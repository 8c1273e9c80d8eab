// The mission's tree: a row a behaviour, its status by a mark as well as by colour, and what it says.

import { $, age, h, setClass, setText } from "./dom.js";

const MARKS = { INVALID: "·", RUNNING: "▶", SUCCESS: "✔", FAILURE: "✘" };

export function mountTree(store) {
  const list = $("tree");
  const panel = list.closest(".panel");
  let shape = "";
  let rows = [];
  let current = -1;
  let last = null;
  let touched = 0;
  for (const kind of ["pointerdown", "wheel", "keydown"]) list.addEventListener(kind, () => (touched = performance.now()), { passive: true });

  function build(view) {
    rows = view.rows.map(([name, word, depth]) => {
      const parts = { mark: h("i", { "aria-hidden": "true" }), says: h("span") };
      const own = name === word || !word ? name : `${name}`;
      parts.row = h("div", { class: "node", title: word && word !== name ? `${name} (${word})` : name }, parts.mark, h("b", {}, own), parts.says);
      parts.row.style.setProperty("--depth", depth);
      return parts;
    });
    list.replaceChildren(...rows.map((parts) => parts.row));
    if (view.hidden) list.append(h("p", { class: "aside" }, `${view.hidden} more`));
  }

  store.onDraw(() => {
    const view = store.shown.tree;
    if (!view) return;
    setClass(panel, "stale", !store.past && !view.fresh);
    setText($("tree-age"), store.past ? `tick ${view.tick}` : view.fresh ? `tick ${view.tick}${view.paused ? ", paused" : ""}` : view.message || age(view.age_s));
    if (view === last) return;
    last = view;
    const now = view.rows.map((row) => `${row[2]}${row[0]}`).join("\n");
    if (now !== shape) {
      shape = now;
      build(view);
    }
    view.rows.forEach(([, , , status, active, says], index) => {
      const parts = rows[index];
      const name = `node ${status}${active ? " active" : ""}${index === view.current ? " current" : ""}`;
      if (parts.row.className !== name) {
        parts.row.className = name;
        setText(parts.mark, MARKS[status]);
        parts.row.setAttribute("aria-label", `${view.rows[index][0]}: ${status.toLowerCase()}`);
      }
      setText(parts.says, says);
    });
    if (view.current !== current) {
      current = view.current;
      // not under the fingers of somebody who reads elsewhere in it
      if (current >= 0 && performance.now() - touched > 4000) reveal(rows[current].row);
    }
  });

  function reveal(row) {
    const [top, bottom] = [row.offsetTop - list.offsetTop, row.offsetTop - list.offsetTop + row.offsetHeight];
    if (top < list.scrollTop + 30 || bottom > list.scrollTop + list.clientHeight - 30) list.scrollTop = top - list.clientHeight / 2;
  }
}
