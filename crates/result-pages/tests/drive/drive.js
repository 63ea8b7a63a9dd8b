"use strict";
// Moves every slider, points at every chart, sorts the tables, switches the theme, and leaves what it saw.
{
  const seen = { motions: [], charts: [], tables: [], themes: [], unlabelled: [] };
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];

  for (const place of all(".motion")) {
    const [slider, canvas, readout] = [place.querySelector("input.frame"), place.querySelector("canvas"), place.querySelector(".readout")];
    const move = (value) => {
      slider.value = String(value);
      slider.dispatchEvent(new Event("input"));
      return { picture: canvas.toDataURL(), text: readout.textContent };
    };
    const n = Number(slider.max) + 1;
    const [first, last] = [move(0), move(n - 1)];
    const box = canvas.getBoundingClientRect();
    canvas.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + 0.4 * box.width, clientY: box.top + 0.4 * box.height }));
    const pointed = readout.textContent;
    const pictures = all("option", place.querySelector("select.layer")).map((option) => {
      place.querySelector("select.layer").value = option.value;
      place.querySelector("select.layer").dispatchEvent(new Event("change"));
      return canvas.toDataURL();
    });
    seen.motions.push({
      frames: n, moves: first.picture !== last.picture, texts: [first.text, last.text], pointed,
      value: slider.getAttribute("aria-valuetext"), layers: pictures.length,
      isBlank: canvas.width * canvas.height === 0,
    });
  }

  for (const place of all(".chart")) {
    const readout = place.parentElement.querySelector(".readout");
    const over = place.querySelector(".u-over");
    const box = over.getBoundingClientRect();
    const point = (part) => {
      const at = { clientX: box.left + part * box.width, clientY: box.top + 0.5 * box.height, bubbles: true, view: window };
      over.dispatchEvent(new MouseEvent("mouseenter", at));
      over.dispatchEvent(new MouseEvent("mousemove", at));
      return all("strong, li", readout).map((it) => it.textContent);
    };
    const press = (key) => {
      place.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
      return all("strong, li", readout).map((it) => it.textContent);
    };
    seen.charts.push({ start: point(0.001), end: point(0.999), home: press("Home"), next: press("ArrowRight") });
  }

  for (const table of all("table.sortable")) {
    const head = table.querySelector("thead th:nth-child(2)");
    const column = () => [...table.tBodies[0].rows].map((row) => row.cells[1].textContent);
    const click = () => {
      head.querySelector("button").click();
      return { order: head.getAttribute("aria-sort"), column: column() };
    };
    seen.tables.push([click(), click()]);
  }

  // Contrast of text on its ground (WCAG 2.2, relative luminance).
  const light = (colour) => {
    const [r, g, b] = colour.match(/[\d.]+/g).slice(0, 3).map((it) => Number(it) / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (element) => {
    let ground = element;
    while (ground && getComputedStyle(ground).backgroundColor === "rgba(0, 0, 0, 0)") ground = ground.parentElement;
    const [a, b] = [light(getComputedStyle(element).color), light(getComputedStyle(ground ?? document.documentElement).backgroundColor)];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  };
  const texts = () => all("h1, h2, p, a, li, dt, dd, td, th, button, summary, figcaption, span, code").filter((it) => it.textContent.trim() && it.offsetParent);
  for (let k = 0; k < 2; k++) {
    const least = texts().map((it) => [contrast(it), it.textContent.trim().slice(0, 40)]).sort((a, b) => a[0] - b[0])[0];
    seen.themes.push({
      ground: getComputedStyle(document.body).backgroundColor, contrast: least[0], where: least[1],
      picture: document.querySelector(".motion canvas")?.toDataURL().length ?? 0,
    });
    document.getElementById("theme").click();
  }

  // What a reader of the screen would meet without a name.
  for (const element of all("input, select, button, canvas.field, .chart, section")) {
    if (element.closest("[hidden]")) continue;
    const named = element.getAttribute("aria-label") || element.textContent.trim()
      || (element.getAttribute("aria-labelledby") ?? "").split(" ").map((id) => document.getElementById(id)?.textContent ?? "").join("").trim()
      || element.labels?.[0]?.textContent.trim();
    if (!named) seen.unlabelled.push(element.outerHTML.slice(0, 80));
  }
  seen.described = all(".chart").map((it) => document.getElementById(it.getAttribute("aria-describedby")).textContent);
  seen.errors = heard;
  seen.requests = performance.getEntriesByType("resource").map((it) => it.name);
  seen.hostile = document.body.dataset.hostile ?? null;
  seen.width = document.documentElement.scrollWidth - innerWidth;
  const outcome = document.createElement("pre");
  outcome.id = "outcome";
  // Base64 of UTF-8: nothing in it can be mistaken for markup.
  outcome.textContent = btoa(String.fromCharCode(...new TextEncoder().encode(JSON.stringify(seen))));
  document.body.append(outcome);
}
