// The page: who we are, which page is shown, and the panels.

import { $, onTheme, setText } from "./dom.js";
import { Link } from "./link.js";
import { Store } from "./store.js";
import { mountStatus } from "./status.js";
import { mountCamera } from "./camera.js";
import { mountRadar } from "./radar.js";
import { mountMap } from "./map.js";
import { mountTree } from "./tree.js";
import { mountEvents } from "./events.js";
import { mountDrive } from "./drive.js";
import { mountWords } from "./words.js";
import { mountPast } from "./past.js";
import { mountEditor } from "./editor.js";
import { mountSettings } from "./settings.js";

const KEY = "target_nav.token";
const PAGES = ["watch", "missions", "settings"];

// The token comes behind the #, which is never sent; it does not stay in the address, which people show to others.
function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    sessionStorage.setItem(KEY, given);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem(KEY);
}

const store = new Store();
const link = new Link(takeToken());

mountStatus(store, link);
mountCamera(store, link);
mountRadar(store);
mountMap(store);
mountTree(store);
mountEvents(store);
const driving = mountDrive(store, link);
mountWords(store, link, driving);
mountPast(store, link);
mountEditor(store, link);
mountSettings(store, link);

store.afterDraw = () => link.seen();
link.addEventListener("views", (event) => store.take(event.detail));
onTheme(() => store.touch());

// -- pages ------------------------------------------------------------------------------------------------------------

function wantPictures() {
  link.want({ pictures: !$("page-watch").hidden && !document.hidden, views: !document.hidden });
}

function showPage(name) {
  const shown = PAGES.includes(name) ? name : "watch";
  for (const page of PAGES) {
    $(`page-${page}`).hidden = page !== shown;
    const tab = $(`tab-${page}`);
    tab.setAttribute("aria-selected", String(page === shown));
    tab.tabIndex = page === shown ? 0 : -1;
    document.body.classList.toggle(`page-${page}`, page === shown);
  }
  wantPictures();
  store.touch();
}

for (const page of PAGES) $(`tab-${page}`).addEventListener("click", () => (location.hash = page));
document.querySelector(".tabs").addEventListener("keydown", (event) => {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!step) return;
  const now = PAGES.findIndex((page) => !$(`page-${page}`).hidden);
  const next = PAGES[(now + step + PAGES.length) % PAGES.length];
  location.hash = next;
  $(`tab-${next}`).focus();
});
window.addEventListener("hashchange", () => {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (token) link.become(takeToken());
  showPage(location.hash.slice(1));
});
document.addEventListener("visibilitychange", wantPictures);

// -- who we are -------------------------------------------------------------------------------------------------------

const dialog = $("token-dialog");
function showRole() {
  store.role = link.open ? link.role : "spectator";
  document.body.classList.remove("loading");
  document.body.dataset.role = store.role;
  setText($("role"), store.role === "operator" ? "Operator" : "Watching only · operate…");
  store.touch();
}
link.addEventListener("welcome", showRole);
link.addEventListener("lost", showRole);
link.addEventListener("refused", () => {
  sessionStorage.removeItem(KEY);
  setText($("token-problem"), "That token is not the right one.");
  if (!dialog.open) dialog.showModal();
});
$("role").addEventListener("click", () => {
  if (store.role === "operator") return;
  setText($("token-problem"), "");
  dialog.showModal();
});
dialog.addEventListener("close", () => {
  const token = $("token-input").value.trim();
  $("token-input").value = "";
  if (dialog.returnValue !== "ok" || !token) return;
  sessionStorage.setItem(KEY, token);
  link.become(token);
});

showPage(location.hash.slice(1));
