// The one connection: newest views in, questions out. It comes back by itself, and says when it is away.

const SILENT_MS = 1500;
const ANSWER_MS = 130000;

export class Link extends EventTarget {
  constructor(token) {
    super();
    this.token = token;
    this.role = null;
    this.open = false;
    this.waiting = new Map();
    this.next = 1;
    this.heard = performance.now();
    this.views = this.pictures = 0;
    this.wants = { pictures: false, views: true };
    this.delay = 250;
    setInterval(() => this.watch(), 250);
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = (this.socket = new WebSocket(`${scheme}://${location.host}/ws`));
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.views = this.pictures = 0;
      this.say({ t: "hello", token: this.token || null });
      this.say({ t: "want", ...this.wants });
    };
    socket.onmessage = (event) => {
      if (this.socket === socket) this.take(event.data);
    };
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.socket = null;
      this.open = false;
      for (const { reject } of this.waiting.values()) reject(new Error("the connection to the console was lost"));
      this.waiting.clear();
      if (event.code === 4401) {
        this.token = null;
        this.delay = 0;
        this.dispatchEvent(new Event("refused"));
      }
      this.dispatchEvent(new Event("lost"));
      setTimeout(() => this.connect(), this.delay);
      this.delay = Math.min(Math.max(this.delay * 1.6, 250), 3000);
    };
  }

  // Another token: from the beginning.
  become(token) {
    this.token = token;
    this.delay = 0;
    this.socket?.close(1000);
  }

  watch() {
    const silent = performance.now() - this.heard;
    if (this.open && !document.hidden && silent > SILENT_MS) this.dispatchEvent(new CustomEvent("silent", { detail: silent / 1000 }));
    // the other end takes a page that says nothing for gone
    if (this.open && performance.now() - (this.saidAt || 0) > 4000) this.say({ t: "seen", views: this.views, pictures: this.pictures });
  }

  take(data) {
    this.heard = performance.now();
    if (typeof data !== "string") {
      const head = new DataView(data);
      this.pictures = head.getUint32(0, true);
      const detail = { age_s: head.getUint32(4, true) / 1000, blob: new Blob([new Uint8Array(data, 8)], { type: "image/jpeg" }) };
      this.dispatchEvent(new CustomEvent("picture", { detail }));
      return;
    }
    const message = JSON.parse(data);
    if (message.t === "views") {
      this.views = message.n;
      this.dispatchEvent(new CustomEvent("views", { detail: message }));
    } else if (message.t === "answer") {
      const waiting = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      if (!waiting) return;
      clearTimeout(waiting.timer);
      if ("error" in message) waiting.reject(new Error(message.error));
      else waiting.resolve(message.value);
    } else if (message.t === "welcome") {
      this.open = true;
      this.delay = 250;
      this.role = message.role;
      this.dispatchEvent(new Event("welcome"));
    } else if (message.t === "refused") {
      this.dispatchEvent(new CustomEvent("drive-refused", { detail: message.why }));
    }
  }

  // What has been drawn; only then more is sent.
  seen() {
    this.say({ t: "seen", views: this.views, pictures: this.pictures });
  }

  want(wants) {
    Object.assign(this.wants, wants);
    if (this.open) this.say({ t: "want", ...this.wants });
  }

  say(message) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    this.saidAt = performance.now();
    return true;
  }

  ask(what, args = {}) {
    return new Promise((resolve, reject) => {
      const id = this.next++;
      if (!this.open || !this.say({ t: "ask", id, what, args })) {
        reject(new Error("no connection to the console"));
        return;
      }
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        reject(new Error(`${what}: no answer from the console`));
      }, ANSWER_MS);
      this.waiting.set(id, { resolve, reject, timer });
    });
  }
}
