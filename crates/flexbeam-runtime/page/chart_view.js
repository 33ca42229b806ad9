// The part of a plot that a person has chosen to see.
// Enters: gestures, as shares of the plot. Leaves: ends of the axes; null where the plot chooses them itself.

/** Ends moved together or apart around a point. */
function scaled([low, high], factor, share) {
  const centre = low + share * (high - low);
  return [centre + (low - centre) * factor, centre + (high - centre) * factor];
}

function moved([low, high], share) {
  const by = share * (high - low);
  return [low + by, high + by];
}

function cut([low, high], from, to) {
  return [low + Math.min(from, to) * (high - low), low + Math.max(from, to) * (high - low)];
}

/** Ends of one horizontal and up to two vertical axes, in the coordinates of the axes. */
export class View {
  constructor() {
    this.reset();
  }

  get zoomed() {
    return this.x !== null || this.y.some((ends) => ends !== null);
  }

  /** Back to what the plot chooses. */
  reset() {
    this.x = null;
    this.y = [null, null];
  }

  /**
   * @param {{x: [number, number], y: [number, number][]}} axes ends as they are shown
   * @param {number} factor below 1: closer
   * @param {number} share where the point stands still, from 0 to 1
   */
  zoomX(axes, factor, share) {
    this.x = scaled(axes.x, factor, share);
  }

  zoomY(axes, factor, share) {
    axes.y.forEach((ends, k) => (this.y[k] = scaled(ends, factor, share)));
  }

  /** Moves by shares of what is shown. */
  pan(axes, right, up) {
    if (right !== 0) this.x = moved(axes.x, right);
    if (up !== 0) axes.y.forEach((ends, k) => (this.y[k] = moved(ends, up)));
  }

  /** The rectangle between two points, given as shares from the left and from below. */
  box(axes, a, b) {
    this.x = cut(axes.x, a.x, b.x);
    axes.y.forEach((ends, k) => (this.y[k] = cut(ends, a.y, b.y)));
  }
}
