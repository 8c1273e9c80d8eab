// The bar: what the robot does, and how old each of its senses is. It always shows the present.

import { $, age, h, setClass, setText } from "./dom.js";

const MOVING = new Set(["NAVIGATING", "SEARCHING", "SPIRAL_SEARCH", "BLIND_APPROACH"]);

function look(status) {
  if (!status || !status.fresh) return "";
  if (status.manual) return "moving";
  if (status.outcome === "failed") return "bad";
  if (status.paused) return "paused";
  if (status.state === "ARRIVED" || status.outcome === "succeeded") return "good";
  return MOVING.has(status.state) ? "moving" : "";
}

export function mountStatus(store, link) {
  const chips = new Map();
  let lost = "";
  const state = $("state");

  function drawLinks(links) {
    for (const each of links) {
      let chip = chips.get(each.name);
      if (!chip) {
        const text = h("span");
        const item = h("li", {}, each.label, text);
        chips.set(each.name, (chip = { item, text }));
        $("links").append(item);
      }
      setText(chip.text, each.text);
      setClass(chip.item, "stale", !each.fresh && !each.quiet);
      setClass(chip.item, "quiet-link", !each.fresh && each.quiet);
      const title = each.problem || `${each.label}: ${each.text} old, limit ${each.limit_s} s`;
      if (chip.item.title !== title) chip.item.title = title;
    }
  }

  function draw({ live }) {
    const status = live.status;
    if (!status) return;
    const shown = lost ? "" : look(status);
    if (state.dataset.state !== shown) state.dataset.state = shown;
    const nav = status.links.find((each) => each.name === "nav");
    const last = !status.fresh && status.state && nav;
    setText($("headline"), last ? `${status.headline}, ${nav.text} ago` : status.headline);
    setClass($("headline"), "old", !status.fresh);
    setText($("mission"), status.mission || "");
    const speed = status.speed_mps > 0.005 || Math.abs(status.yaw_rate_radps) > 0.01
      ? ` · ${status.speed_mps.toFixed(2)} m/s` : "";
    const limited = status.limited_by && speed ? ` · held back by ${status.limited_by}` : "";
    setText($("story"), [status.leaf, status.outcome_reason || status.reason].filter(Boolean).join(": ") + speed + limited);
    drawLinks(status.links);
    const banner = $("banner");
    setClass(banner, "lost", Boolean(lost));
    setText(banner, lost || status.banner);
    banner.hidden = !banner.textContent;
    const title = `${status.headline} · ${status.mission || "target_nav"}`;
    if (document.title !== title) document.title = title;
  }

  function away(text) {
    lost = text;
    setClass(document.body, "lost", Boolean(text));
    if (text) {
      $("banner").hidden = false;
      setClass($("banner"), "lost", true);
      setText($("banner"), text);
      state.dataset.state = "";
    }
  }

  link.addEventListener("lost", () =>
    away("No connection to the console. A mission goes on without it; driving by hand has stopped. To stop the robot use its own panel or switch."));
  link.addEventListener("silent", (event) => away(`The console has said nothing for ${age(event.detail)}.`));
  link.addEventListener("views", () => away(""));
  store.onDraw(draw);
}
