import { defineConfig } from "vite";

// Names bear a hash of the contents, so the server lets browsers keep everything but index.html.
export default defineConfig({
  base: "./",
  build: {
    outDir: "../crates/seatrial-dash/dist",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: { polyfill: false },
  },
});
