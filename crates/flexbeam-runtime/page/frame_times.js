// How long the work of a frame takes [ms]: for tests and measurements, by window.flexbeam.frames.

export class FrameTimes {
  constructor() {
    this.reset();
  }

  /** Forgets what was measured. */
  reset() {
    Object.assign(this, { count: 0, last_ms: 0, max_ms: 0, mean_ms: 0 });
  }

  /** Takes the work of one frame in. */
  add(ms) {
    this.count += 1;
    this.last_ms = ms;
    this.max_ms = Math.max(this.max_ms, ms);
    this.mean_ms += (ms - this.mean_ms) / this.count;
  }
}
