import type { Floats32, Floats64, Unsigned32 } from "./page_data.ts";

/** Decodes base64 into 32-bit floats; throws on malformed base64 or an incomplete number. The page stores the least
 * significant byte first, as do all machines that run a browser. */
export function floats32(text: Floats32): Float32Array {
  return new Float32Array(bytes(text, 4));
}

/** Decodes 64-bit floats in the same way. */
export function floats64(text: Floats64): Float64Array {
  return new Float64Array(bytes(text, 8));
}

/** Decodes unsigned 32-bit integers in the same way. */
export function unsigned32(text: Unsigned32): Uint32Array {
  return new Uint32Array(bytes(text, 4));
}

/** Encodes numbers as base64, the inverse of the functions above: `floats64(base64(row)) = row`. */
export function base64(row: Float32Array | Float64Array | Uint32Array): string {
  const all = new Uint8Array(row.buffer, row.byteOffset, row.byteLength);
  const parts: string[] = [];
  for (let at = 0; at < all.length; at += PART) {
    parts.push(String.fromCharCode(...all.subarray(at, at + PART)));
  }
  return btoa(parts.join(""));
}

/** Decodes base64 into bytes; throws unless their number is a multiple of `size`. */
export function bytes(text: string, size = 1): ArrayBuffer {
  const binary = atob(text);
  if (binary.length % size !== 0) {
    throw new RangeError(`${binary.length} bytes are no row of numbers of ${size} bytes`);
  }
  const all = new Uint8Array(binary.length);
  for (let at = 0; at < binary.length; at += 1) all[at] = binary.charCodeAt(at);
  return all.buffer;
}

/** Number of arguments that every JavaScript engine accepts for one call. */
const PART = 8192;
