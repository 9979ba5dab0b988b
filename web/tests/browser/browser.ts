import { spawn, type ChildProcess } from "node:child_process";
import { existsSync, mkdirSync, readFileSync } from "node:fs";
import { createServer, type Server } from "node:http";
import type { AddressInfo } from "node:net";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { type Browser, type BrowserContextOptions, chromium, type Page } from "playwright-core";
import type { Inspection } from "../../src/inspection.ts";
import type { PageData, Verdict } from "../../src/data/page_data.ts";

/** The folder `web`. */
export const WEB = join(dirname(fileURLToPath(import.meta.url)), "..", "..", "..");
export const DIST = join(WEB, "dist");
export const SCREENSHOTS = join(WEB, "screenshots");

/** The program; if it is not set, tests that need it are skipped. */
export const CRANNY = process.env["CRANNY_BIN"] ?? "";

const CHROMIUM = process.env["CRANNY_CHROMIUM"] ?? "/usr/bin/chromium";

/** Long, because slow machines render without a graphics card. */
export const PATIENCE_MS = 30_000;

export function launch(): Promise<Browser> {
  return chromium.launch({
    executablePath: CHROMIUM,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
  });
}

/** Content security policy with which the program serves the page. */
const POLICY = [
  "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:",
  "font-src 'self' data:; connect-src 'self'; worker-src 'self' blob:; base-uri 'none'; form-action 'none'",
  "frame-ancestors 'none'",
].join("; ");

const TYPES: Record<string, string> = { html: "text/html", js: "text/javascript", css: "text/css" };

/** Serves the built page with data, as the program does. */
export async function serve(
  data: PageData,
  judge?: (q: number[]) => Verdict,
  news?: (after: number) => Promise<unknown>,
  nodes?: (after: number) => unknown,
): Promise<{ address: string; close(): Promise<void> }> {
  const server: Server = createServer((request, response) => {
    const path = new URL(request.url ?? "/", "http://localhost").pathname;
    response.setHeader("content-security-policy", POLICY);
    if (path === "/page.json") {
      response.setHeader("content-type", "application/json").end(JSON.stringify(data));
    } else if (path === "/news" && news) {
      const after = Number(new URL(request.url ?? "/", "http://localhost").searchParams.get("after"));
      void news(after).then((told) => response.end(JSON.stringify(told)));
    } else if (path === "/tree" && nodes) {
      const after = Number(new URL(request.url ?? "/", "http://localhost").searchParams.get("after"));
      response.end(JSON.stringify(nodes(after)));
    } else if (path === "/verdict" && judge) {
      let body = "";
      request.on("data", (part) => (body += part));
      request.on("end", () => response.end(JSON.stringify(judge((JSON.parse(body) as { q: number[] }).q))));
    } else {
      const file = join(DIST, path === "/" ? "index.html" : path);
      if (!existsSync(file)) return void response.writeHead(404).end();
      response.setHeader("content-type", TYPES[file.split(".").pop() ?? ""] ?? "text/plain").end(readFileSync(file));
    }
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  return {
    address: `http://127.0.0.1:${(server.address() as AddressInfo).port}/`,
    close: () =>
      new Promise((resolve) => {
        server.closeAllConnections();
        server.close(() => resolve());
      }),
  };
}

/** Runs `cranny view` until it is stopped. */
export async function view(...args: string[]): Promise<{ address: string; stop(): Promise<number | null> }> {
  const program: ChildProcess = spawn(CRANNY, ["view", ...args, "--no-open", "--port", "0"], { stdio: "pipe" });
  let said = "";
  const address = await new Promise<string>((resolve, reject) => {
    const listen = (part: Buffer): void => {
      said += part.toString();
      const found = /http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{32}\//.exec(said);
      if (found) resolve(found[0]);
    };
    program.stdout?.on("data", listen);
    program.stderr?.on("data", listen);
    program.on("exit", (code) => reject(new Error(`cranny view ended with ${code}: ${said}`)));
  });
  return {
    address,
    stop: () =>
      new Promise((resolve) => {
        program.on("exit", (code) => resolve(code));
        program.kill("SIGINT");
      }),
  };
}

export interface Opened {
  page: Page;
  /** Warnings and errors of the console, and failed requests. */
  complaints: string[];
}

export async function open(browser: Browser, address: string, options: BrowserContextOptions = {}): Promise<Opened> {
  // With reduced motion, a page stands still when it opens.
  const still = { viewport: { width: 960, height: 640 }, reducedMotion: "reduce" as const };
  const context = await browser.newContext({ ...still, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  const complaints: string[] = [];
  page.on("console", (message) => {
    // The driver warns that software rendering is slow.
    const isOfDriver = /GPU stall|GL Driver Message|swiftshader/i.test(message.text());
    if (["error", "warning"].includes(message.type()) && !isOfDriver) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("requestfailed", (request) => complaints.push(`${request.url()}: ${request.failure()?.errorText}`));
  await page.goto(address);
  await page.waitForFunction(() => window.cranny !== undefined);
  await rest(page);
  return { page, complaints };
}

/** Waits until the page has drawn all changes. */
export async function rest(page: Page): Promise<void> {
  await page.waitForFunction(() => window.cranny?.isIdle === true);
}

/** Reads one of the figures that the page provides. */
export function look<Name extends keyof Inspection>(page: Page, name: Name): Promise<Inspection[Name]> {
  return page.evaluate((key) => window.cranny![key] as never, name);
}

/** Saves a screenshot for inspection. */
export async function picture(page: Page, name: string): Promise<void> {
  mkdirSync(SCREENSHOTS, { recursive: true });
  await page.screenshot({ path: join(SCREENSHOTS, `${name}.png`) });
}
