import type { Browser } from "playwright-core";

/** Channel differences below this are rendering noise. */
const SEEN = 12;

/** Fraction of pixels that differ between two pictures of the same size. */
export async function difference(browser: Browser, a: Buffer, b: Buffer): Promise<number> {
  const page = await browser.newPage();
  const share = await page.evaluate(
    async ([first, second, seen]) => {
      const points = async (png: string): Promise<Uint8ClampedArray> => {
        const image = new Image();
        image.src = `data:image/png;base64,${png}`;
        await image.decode();
        const canvas = new OffscreenCanvas(image.width, image.height);
        const pen = canvas.getContext("2d");
        if (!pen) throw new Error("no canvas");
        pen.drawImage(image, 0, 0);
        return pen.getImageData(0, 0, image.width, image.height).data;
      };
      const [one, other] = [await points(first as string), await points(second as string)];
      let different = 0;
      for (let at = 0; at < one.length; at += 4) {
        const step = [0, 1, 2].map((i) => Math.abs(one[at + i] - other[at + i]));
        if (Math.max(...step) >= (seen as number)) different += 1;
      }
      return different / (one.length / 4);
    },
    [a.toString("base64"), b.toString("base64"), SEEN] as const,
  );
  await page.close();
  return share;
}
