// What happened, a line each, newest last.

import { $, h } from "./dom.js";

const MARKS = { info: "·", good: "✔", warn: "▲", bad: "✘" };

export function mountEvents(store) {
  const list = $("events");
  let last = 0;
  store.onDraw(({ live }) => {
    const events = live.events;
    if (!events?.length) return;
    const newest = events[events.length - 1][0];
    if (newest === last) return;
    if (newest < last) list.replaceChildren(); // another console process
    const fresh = newest < last ? events : events.filter((event) => event[0] > last);
    last = newest;
    const atEnd = list.scrollTop + list.clientHeight > list.scrollHeight - 40;
    for (const [, clock, level, text] of fresh) {
      list.append(h("li", { class: level }, h("time", {}, clock), h("i", { "aria-label": level }, MARKS[level] ?? "·"), h("span", {}, text)));
    }
    while (list.childElementCount > 300) list.firstElementChild.remove();
    if (atEnd) list.scrollTop = list.scrollHeight;
  });
}
