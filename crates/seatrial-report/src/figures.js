/* Values under the pointer, zoom by dragging, a legend that hides its line. */
(function () {
  "use strict";
  function list(found) { return Array.prototype.slice.call(found); }
  function ends(text) { return text.split(" ").map(Number); }
  function short(value) {
    var size = Math.abs(value);
    var text = size > 0 && 1e-3 > size ? value.toExponential(2) : String(Number(value.toPrecision(4)));
    return text.replace(/-/g, "−");
  }

  /* The points of a path as [x, y, begins a line], absolute. */
  function points(path) {
    var x = 0, y = 0, found = [];
    path.replace(/([MlhvV])([^MlhvV]*)/g, function (all, letter, rest) {
      var n = rest.trim().split(/\s+/).map(Number);
      if (letter === "M") { x = n[0]; y = n[1]; }
      if (letter === "l") { x += n[0]; y += n[1]; }
      if (letter === "h") { x += n[0]; }
      if (letter === "v") { y += n[0]; }
      if (letter === "V") { y = n[0]; }
      found.push([x, y, letter === "M"]);
      return "";
    });
    return found;
  }

  function ticks(from, to) {
    var rough = (to - from) / 7, power = Math.pow(10, Math.floor(Math.log10(rough)));
    var step = [1, 2, 5, 10].map(function (m) { return m * power; }).find(function (s) { return s >= 0.7 * rough; });
    var found = [];
    for (var k = Math.ceil(from / step); to + 1e-9 * step >= k * step; k += 1) found.push(k * step);
    var digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    return { at: found, text: function (value) { return value.toFixed(digits).replace("-", "−"); } };
  }

  function Plot(svg) {
    var box = svg.viewBox.baseVal;
    this.svg = svg;
    this.width = box.width;
    this.height = box.height;
    this.y = ends(svg.dataset.y);
    this.isLog = "log" in svg.dataset;
    this.title = svg.parentNode.querySelector(".axis-label").textContent;
    this.moved = list(svg.querySelectorAll("path:not(.grid)")).map(function (path) {
      return { path: path, points: points(path.getAttribute("d")) };
    });
    this.grid = svg.querySelector(".grid");
    this.gridPath = this.grid.getAttribute("d");
    this.shades = list(svg.querySelectorAll("rect[x]")).map(function (rect) {
      return { rect: rect, x: +rect.getAttribute("x"), width: +rect.getAttribute("width") };
    });
    this.dots = list(svg.querySelectorAll("circle")).map(function (dot) {
      return { dot: dot, x: +dot.getAttribute("cx"), y: +dot.getAttribute("cy") };
    });
    var keys = list(svg.parentNode.querySelectorAll(".key"));
    this.layers = list(svg.querySelectorAll("g[data-ink]")).map(function (layer) {
      var key = keys.find(function (one) { return one.dataset.ink === layer.dataset.ink; });
      return { layer: layer, name: key ? key.textContent : "" };
    });
    this.cursor = document.createElementNS(svg.namespaceURI, "path");
    this.cursor.setAttribute("class", "cursor");
    svg.appendChild(this.cursor);
  }

  /* Draws from `a` to `b`, in the units of the whole width. */
  Plot.prototype.show = function (a, b, verticals) {
    var width = this.width, scale = width / (b - a);
    var x = function (at) { return Math.round((at - a) * scale); };
    this.moved.forEach(function (one) {
      one.path.setAttribute("d", one.points.map(function (p) { return (p[2] ? "M" : "L") + x(p[0]) + " " + p[1]; }).join(""));
    });
    this.shades.forEach(function (one) {
      one.rect.setAttribute("x", x(one.x));
      one.rect.setAttribute("width", Math.round(one.width * scale));
    });
    this.dots.forEach(function (one) { one.dot.setAttribute("cx", x(one.x)); });
    var height = this.height;
    var upright = verticals.map(function (at) { return "M" + x(at) + " 0v" + height; }).join("");
    this.grid.setAttribute("d", verticals.length ? this.gridPath.replace(/M[^Mv]*v[^M]*/g, "") + upright : this.gridPath);
  };

  Plot.prototype.value = function (y) {
    var even = this.y[1] - y / this.height * (this.y[1] - this.y[0]);
    return this.isLog ? Math.pow(10, even) : even;
  };

  /* What its lines are at `at`, one text each. */
  Plot.prototype.read = function (at) {
    var plot = this, title = this.title.split(", "), unit = title.length > 1 ? " " + title.pop() : "";
    var texts = [];
    this.layers.forEach(function (one) {
      if (one.layer.classList.contains("off")) return;
      var best = null, far = 0.17 * plot.width;
      plot.moved.forEach(function (line) {
        var isFlat = line.points.length === 2 && line.points[0][1] === line.points[1][1];
        if (line.path.parentNode !== one.layer || line.points.some(function (p, k) { return p[2] && k > 0 && line.points.length === 6; })) return;
        line.points.forEach(function (p) {
          var off = isFlat ? 0 : Math.abs(p[0] - at);
          if (far > off) { far = off; best = p[1]; }
        });
      });
      plot.dots.forEach(function (dot) {
        var off = Math.abs(dot.x - at);
        if (dot.dot.parentNode === one.layer && Math.min(far, 0.04 * plot.width) > off) { far = off; best = dot.y; }
      });
      if (best !== null) texts.push(title.join(", ") + (one.name ? " " + one.name : "") + ": " + short(plot.value(best)) + unit);
    });
    return texts;
  };

  list(document.querySelectorAll("svg.chart")).forEach(function (chart) {
    var plots = list(chart.querySelectorAll("svg.plot")).map(function (svg) { return new Plot(svg); });
    if (plots.length === 0) return;
    var first = plots[0].svg, whole = ends(first.dataset.x), left = +first.getAttribute("x"), wide = +first.getAttribute("width");
    var tenths = plots[0].width, seen = [0, tenths], held = null;
    var readout = document.createElement("div");
    readout.className = "readout";
    readout.hidden = true;
    chart.parentNode.insertBefore(readout, chart.nextSibling);
    var tickTexts = list(chart.querySelectorAll(".tick.x"));
    var label = list(chart.querySelectorAll(".axis-label.middle"))[0].textContent;

    function valueOf(at) { return whole[0] + at / tenths * (whole[1] - whole[0]); }
    function placeOf(value) { return (value - whole[0]) / (whole[1] - whole[0]) * tenths; }
    /* Where the pointer is, in the units of the whole width; null beside the plots. */
    function place(event) {
      var box = chart.getBoundingClientRect(), unit = box.width / chart.viewBox.baseVal.width;
      var share = ((event.clientX - box.left) / unit - left) / wide;
      return share >= 0 && 1 >= share ? seen[0] + share * (seen[1] - seen[0]) : null;
    }
    function show(a, b) {
      seen = [a, b];
      var isWhole = a === 0 && b === tenths, found = ticks(valueOf(a), valueOf(b));
      chart.classList.toggle("zoomed", !isWhole);
      list(chart.querySelectorAll(".tick.new")).forEach(function (text) { text.remove(); });
      if (!isWhole) found.at.forEach(function (value) {
        var text = tickTexts[0].cloneNode(false);
        text.setAttribute("class", "tick new middle");
        text.setAttribute("x", left + (placeOf(value) - a) / (b - a) * wide);
        text.textContent = found.text(value);
        chart.appendChild(text);
      });
      plots.forEach(function (plot) { plot.show(a, b, isWhole ? [] : found.at.map(placeOf)); });
    }
    function mark(at) {
      plots.forEach(function (plot) {
        var x = Math.round((at - seen[0]) / (seen[1] - seen[0]) * tenths);
        var from = held === null ? x : Math.round((held - seen[0]) / (seen[1] - seen[0]) * tenths);
        plot.cursor.setAttribute("d", "M" + from + " 0V" + plot.height + "H" + x + "V0Z");
      });
    }
    function leave() {
      readout.hidden = true;
      held = null;
      plots.forEach(function (plot) { plot.cursor.removeAttribute("d"); });
    }
    chart.addEventListener("pointermove", function (event) {
      var at = place(event);
      if (at === null) { if (held === null) leave(); return; }
      mark(at);
      var rows = [label.split(", ")[0] + ": " + short(valueOf(at)) + " " + (label.split(", ")[1] || "")];
      plots.forEach(function (plot) { rows = rows.concat(plot.read(at)); });
      readout.textContent = rows.join("\n");
      readout.hidden = false;
      var box = chart.getBoundingClientRect(), isRight = event.clientX - box.left > box.width / 2;
      readout.style.left = isRight ? "0" : "auto";
      readout.style.right = isRight ? "auto" : "0";
    });
    chart.addEventListener("pointerdown", function (event) {
      if (event.pointerType !== "mouse" || event.button !== 0 || event.target.closest(".key")) return;
      held = place(event);
      event.preventDefault();
    });
    chart.addEventListener("pointerup", function (event) {
      var at = place(event), from = held;
      held = null;
      if (from !== null && at !== null && Math.abs(at - from) > 0.02 * (seen[1] - seen[0])) {
        show(Math.min(from, at), Math.max(from, at));
        leave();
      }
    });
    chart.addEventListener("pointerleave", leave);
    chart.addEventListener("dblclick", function () { show(0, tenths); });

    var keys = list(chart.querySelectorAll(".key"));
    if (keys.length > 0) chart.setAttribute("role", "group");
    keys.forEach(function (key) {
      key.setAttribute("role", "button");
      key.setAttribute("tabindex", "0");
      key.setAttribute("aria-pressed", "true");
      function toggle() {
        var ink = key.dataset.ink, isOff = key.classList.toggle("off");
        key.setAttribute("aria-pressed", String(!isOff));
        list(chart.querySelectorAll(".plot g[data-ink]")).forEach(function (layer) {
          var isNear = layer.closest(".panel") === key.closest(".panel");
          if (layer.dataset.ink === ink && (isNear || /^s\d$/.test(ink))) layer.classList.toggle("off", isOff);
        });
      }
      key.addEventListener("click", toggle);
      key.addEventListener("keydown", function (event) {
        if (event.key === "Enter" || event.key === " ") { event.preventDefault(); toggle(); }
      });
    });
  });

  /* A link leads into what is folded; paper has no folds. */
  function reveal() {
    var to = location.hash.length > 1 ? document.getElementById(location.hash.slice(1)) : null;
    var fold = to ? to.closest("details") : null;
    if (fold) { fold.open = true; to.scrollIntoView(); }
  }
  var folded = [];
  addEventListener("hashchange", reveal);
  addEventListener("beforeprint", function () {
    folded = list(document.querySelectorAll("details:not([open]):not(.never-printed)"));
    folded.forEach(function (fold) { fold.open = true; });
  });
  addEventListener("afterprint", function () { folded.forEach(function (fold) { fold.open = false; }); });
  reveal();
  list(document.querySelectorAll(".how-figures")).forEach(function (text) { text.hidden = false; });
})();
