// Compares numbers one by one.
import assert from "node:assert/strict";

export const near = (actual, expected, bound = 1e-9) =>
  actual.forEach((x, i) => assert.ok(Math.abs(x - expected[i]) <= bound, `${actual} is not ${expected}`));
