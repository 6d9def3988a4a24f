//! The page that stands alone: one file, with its program in it, that opens without a server.

import { readFileSync } from "node:fs";
import { gzipSync } from "node:zlib";
import { defineConfig, type Plugin } from "vite";

/** Puts scripts, styles and the WebAssembly module that SEATRIAL_WASM names into the page. */
function inOneFile(): Plugin {
  return {
    name: "in-one-file",
    enforce: "post",
    generateBundle(_, bundle) {
      let [script, style] = ["", ""];
      for (const [name, made] of Object.entries(bundle)) {
        if (made.type === "chunk") script += made.code;
        else if (name.endsWith(".css")) style += String(made.source);
        else continue;
        delete bundle[name];
      }
      const page = Object.values(bundle).find((made) => made.fileName === "alone.html");
      if (page?.type !== "asset") return this.error("alone.html was not built");
      const module = process.env["SEATRIAL_WASM"];
      if (module === undefined) return this.error("SEATRIAL_WASM does not name the module");
      const packed = gzipSync(readFileSync(module), { level: 9 }).toString("base64");
      const head = `<style>${style}</style>`;
      // The program comes last, so that the page is seen before it is read.
      const tail = `<script type="module">${script.replaceAll("</script", "<\\/script")}</script><script type="text/plain" id="program">${packed}</script>`;
      page.source = String(page.source)
        .replace(/<script type="module"[^>]*><\/script>/, "")
        .replace(/<link rel="stylesheet"[^>]*>/, "")
        .replace("</head>", () => `${head}</head>`)
        .replace("</body>", () => `</body>${tail}`);
      page.fileName = "seatrial.html";
    },
  };
}

export default defineConfig({
  base: "./",
  plugins: [inOneFile()],
  build: {
    outDir: "../target/alone",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: { polyfill: false },
    rollupOptions: { input: "alone.html" },
  },
});
