import { defineConfig } from "vite";
import { singleFile } from "./single_file.ts";

// For work on the page: `cranny view 011 --no-open`, then `npm run dev` with the address that it prints.
const SERVER = (process.env["CRANNY_VIEW"] ?? "http://127.0.0.1:7878").replace(/\/$/, "");

// The server accepts requests only from its own origin.
const proxy = { target: SERVER, changeOrigin: true, headers: { origin: new URL(SERVER).origin } };

export default defineConfig({
  base: "./",
  plugins: [singleFile()],
  server: { host: "127.0.0.1", proxy: { "/page.json": proxy, "/verdict": proxy } },
  build: {
    // Supported by all browsers of recent years: WebGL 2, DecompressionStream, modules.
    target: "es2022",
    // The page itself names the only chunk; the server's policy allows no inline script.
    modulePreload: false,
    chunkSizeWarningLimit: 1000,
    reportCompressedSize: false,
  },
});
