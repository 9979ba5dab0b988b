import assert from "node:assert/strict";
import { test } from "node:test";
import { base64, floats32, floats64, unsigned32 } from "../../src/data/numbers.ts";

test("numbers come back from base64 bit by bit", () => {
  const row = Float64Array.of(0, -0, 1 / 3, Number.MAX_VALUE, Number.MIN_VALUE, -Math.PI);
  assert.deepEqual(floats64(base64(row)), row);
  assert.deepEqual(unsigned32(base64(Uint32Array.of(0, 1, 2 ** 32 - 1))), Uint32Array.of(0, 1, 2 ** 32 - 1));
});

test("the order of bytes is the one in which the least comes first", () => {
  // 1.0 is 00 00 80 3f.
  assert.deepEqual(floats32("AACAPw=="), Float32Array.of(1));
  assert.equal(Buffer.from(Float32Array.of(1).buffer).toString("base64"), "AACAPw==");
});

test("rows longer than a function has arguments come back too", () => {
  const row = Float32Array.from({ length: 100_000 }, (_, i) => i);
  assert.deepEqual(floats32(base64(row)), row);
});

test("an empty text is an empty row", () => {
  assert.equal(floats64("").length, 0);
});

test("what is no base64, or not whole numbers, throws", () => {
  assert.throws(() => floats32("AACA"), /no row of numbers/);
  assert.throws(() => floats32("not base64!"));
});
