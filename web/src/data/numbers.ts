import type { Floats32, Floats64, Unsigned32 } from "./page_data.ts";

/**
 * The numbers of a base64 text. Every machine that runs a browser keeps numbers as the page does, the least
 * significant byte first; a text that is no base64, or not whole numbers, throws.
 */
export function floats32(text: Floats32): Float32Array {
  return new Float32Array(bytes(text, 4));
}

/** The same for numbers of 64 bits. */
export function floats64(text: Floats64): Float64Array {
  return new Float64Array(bytes(text, 8));
}

/** The same for whole numbers. */
export function unsigned32(text: Unsigned32): Uint32Array {
  return new Uint32Array(bytes(text, 4));
}

/** Numbers as base64, the inverse of the above: `floats64(base64(row)) = row`. */
export function base64(row: Float32Array | Float64Array | Uint32Array): string {
  const all = new Uint8Array(row.buffer, row.byteOffset, row.byteLength);
  const parts: string[] = [];
  for (let at = 0; at < all.length; at += PART) {
    parts.push(String.fromCharCode(...all.subarray(at, at + PART)));
  }
  return btoa(parts.join(""));
}

/** Bytes of a base64 text, a multiple of `size` of them. */
export function bytes(text: string, size = 1): ArrayBuffer {
  const binary = atob(text);
  if (binary.length % size !== 0) {
    throw new RangeError(`${binary.length} bytes are no row of numbers of ${size} bytes`);
  }
  const all = new Uint8Array(binary.length);
  for (let at = 0; at < binary.length; at += 1) all[at] = binary.charCodeAt(at);
  return all.buffer;
}

/** As many arguments as every engine lets a function have. */
const PART = 8192;
