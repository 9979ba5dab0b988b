import { defineConfig } from "vite";
import { singleFile } from "./single_file.ts";

// While the page is worked on: `cranny view 011 --no-open`, then `npm run dev` with the address that it prints.
const SERVER = (process.env["CRANNY_VIEW"] ?? "http://127.0.0.1:7878").replace(/\/$/, "");

// It answers no page of another origin.
const proxy = { target: SERVER, changeOrigin: true, headers: { origin: new URL(SERVER).origin } };

export default defineConfig({
  base: "./",
  plugins: [singleFile()],
  server: { host: "127.0.0.1", proxy: { "/page.json": proxy, "/verdict": proxy } },
  build: {
    // What every browser of the last years can do: WebGL 2, DecompressionStream, modules.
    target: "es2022",
    // The only chunk is named in the page itself; the policy of the server allows no inline script.
    modulePreload: false,
    chunkSizeWarningLimit: 1000,
    reportCompressedSize: false,
  },
});
