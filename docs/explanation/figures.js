// Puts a live figure in place of each picture of one, once the page without a server runs in it. Without scripts, without
// WebAssembly, or in a site that was built without that page, the pictures stay.

const ground = () => (/coal|navy|ayu/.test(document.documentElement.className) ? "dark" : "light");

for (const figure of document.querySelectorAll("figure[data-live]")) {
  const picture = figure.querySelector("img");
  const frame = document.createElement("iframe");
  const address = () => `../seatrial.html#figure/${figure.dataset.live}/${ground()}`;
  frame.title = picture.alt;
  frame.scrolling = "no";
  frame.src = address();
  frame.style.cssText = "position: absolute; visibility: hidden; width: 100%; border: 0;";
  figure.style.position = "relative";
  figure.prepend(frame);
  addEventListener("message", ({ source, data }) => {
    if (source !== frame.contentWindow || data.seatrial !== "figure") return;
    frame.style.cssText = `display: block; width: 100%; border: 0; height: ${data.height}px;`;
    picture.hidden = true;
  });
  // A change of the fragment does not load the page again.
  new MutationObserver(() => frame.contentWindow.location.replace(new URL(address(), location.href))).observe(
    document.documentElement,
    { attributeFilter: ["class"] },
  );
}
