// From fingers (or the mouse) before and after to a movement of the camera. Pure.
// Points are [x, y] in CSS pixels; `side` is the shorter side of the picture, which the lens angle spans.

// One drag over that side turns by this much.
const kRadiansPerSide = Math.PI;

const middle = ([a, b]) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
const gap = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);

// One point turns, or pans when asked to; two pan by their middle and zoom by their gap.
export function gestureOf(before, after, side, panning = false) {
  if (before.length === 1) {
    const [dx, dy] = [(after[0][0] - before[0][0]) / side, (after[0][1] - before[0][1]) / side];
    return panning
      ? { kind: "pan", dx, dy, zoom: 1 }
      : { kind: "orbit", dx: dx * kRadiansPerSide, dy: dy * kRadiansPerSide };
  }
  const [from, to] = [middle(before), middle(after)];
  const [was, is] = [gap(before), gap(after)];
  return {
    kind: "pan",
    dx: (to[0] - from[0]) / side,
    dy: (to[1] - from[1]) / side,
    zoom: was > 0 && is > 0 ? was / is : 1,
  };
}

// deltaMode: 0 counts pixels, 1 lines, 2 pages (WheelEvent). About 10 % a notch.
export function wheelZoom(deltaY, deltaMode) {
  const pixels = deltaY * [1, 16, 400][deltaMode];
  return Math.exp(Math.min(240, Math.max(-240, pixels)) * 0.001);
}
