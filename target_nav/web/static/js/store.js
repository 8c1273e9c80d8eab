// The newest sections, and what is shown: the present, or a frame of the past.

export class Store {
  constructor() {
    this.live = {};
    this.image = null;
    this.past = null; // {label, sections, image, path_m}
    this.marks = [];
    this.draws = [];
    this.dirty = false;
    this.afterDraw = null;
    this.role = "spectator";
  }

  // What the panels show.
  get shown() {
    return this.past ? this.past.sections : this.live;
  }

  get shownImage() {
    return this.past ? this.past.image : this.image;
  }

  take(message) {
    for (const [name, value] of Object.entries(message)) {
      if (name === "t" || name === "n") continue;
      if (name === "marks") this.addMarks(value);
      else this.live[name] = value;
    }
    this.touch();
  }

  addMarks({ begin, add }) {
    const last = this.marks.length ? this.marks[this.marks.length - 1][0] : -1;
    for (const mark of add) if (mark[0] > last) this.marks.push(mark);
    let old = 0;
    while (old < this.marks.length && this.marks[old][0] < begin) old++;
    if (old) this.marks.splice(0, old);
  }

  // Begin anew: the server counts its frames from zero again.
  forget() {
    this.marks = [];
  }

  onDraw(draw) {
    this.draws.push(draw);
  }

  touch() {
    if (this.dirty) return;
    this.dirty = true;
    requestAnimationFrame(() => {
      this.dirty = false;
      for (const draw of this.draws) {
        try {
          draw(this);
        } catch (error) {
          // one panel that fails must not take the others with it, nor the credit for the next message
          console.error(error);
        }
      }
      this.afterDraw?.();
    });
  }
}
