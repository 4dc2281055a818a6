"use strict";
// Which layer and which row are shown, and what is told of a place that was clicked.
const bevelmap = (() => {
  const data = JSON.parse(document.getElementById("plane").textContent);
  const roots = data.document.roots.map((root) => root.id);
  const places = ["map", "curves"].slice(0, roots.length).map((id) => document.getElementById(id));
  const all = (selector) => [...document.querySelectorAll(selector)];
  let map, curves, shown = data.layers[0];

  const parts = (figure) => [...figure.renderers, ...figure.right, ...figure.toolbar.tools];

  function press(buttons, name, value) {
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset[name] === value));
  }

  // Labels that would hide each other are left out of a narrow map: a click says what they say.
  const written = (part) => ["labels", "leaders", "ends"].includes(part.name);
  const narrow = window.matchMedia("(max-width: 560px)");

  function showLayer(name) {
    shown = name;
    for (const part of parts(map))
      if (part.tags.length) part.visible = part.tags.includes(name) && !(narrow.matches && written(part));
    for (const legend of all(".aside[data-layer]")) legend.hidden = legend.dataset.layer !== name;
    press(all("#layers button"), "layer", name);
  }

  function showRow(number) {
    for (const part of parts(curves)) if (part.tags.length) part.visible = part.tags.includes(number);
    press(all("#rows button"), "row", String(number));
    const line = map.center.find((one) => one.name === "row");
    line.location = data.rows[number];
    line.visible = true;
    [curves.y_range.start, curves.y_range.end] = data.ends[number];
  }

  // Whether a place is within one of several polygons that do not overlap.
  function within(xs, ys, x, y) {
    let inside = false;
    for (let k = 0; k < xs.length; k++) {
      const [px] = xs[k], [py] = ys[k];
      for (let i = 0, j = px.length - 1; i < px.length; j = i++)
        if (py[i] > y !== py[j] > y && x < ((px[j] - px[i]) * (y - py[i])) / (py[j] - py[i]) + px[i]) inside = !inside;
    }
    return inside;
  }

  // The class or the value below a place: a number in the data of the layer; null beyond the plane.
  function valueAt(x, y) {
    const drawn = map.renderers.find((one) => one.tags.includes(shown) && ["areas", "cells"].includes(one.name));
    const found = drawn.data_source.data;
    if (drawn.name === "areas") {
      const place = found.xs.findIndex((xs, i) => within(xs, found.ys[i], x, y));
      return place < 0 ? null : found.code[place];
    }
    const [rows, columns] = found.image[0].shape;
    const column = Math.floor(((x - found.x[0]) / found.dw[0]) * columns);
    const row = Math.floor(((y - found.y[0]) / found.dh[0]) * rows);
    return column < 0 || row < 0 || column >= columns || row >= rows ? null : found.image[0][row * columns + column];
  }

  function tell(x, y) {
    const hover = map.toolbar.tools.find((one) => one.type === "HoverTool" && one.tags.includes(shown));
    const value = valueAt(x, y), told = document.getElementById("told");
    told.replaceChildren();
    if (value === null) {
      told.textContent = "Beyond the plane.";
      return;
    }
    const formatters = hover.formatters, [formatter] = formatters.values?.() ?? Object.values(formatters);
    for (const [name, field] of hover.tooltips) {
      const format = field.slice(field.indexOf("{") + 1, -1);
      const text = field.startsWith("$") ? (field[1] === "x" ? x : y).toPrecision(5)
        : formatter.format(value, format, {x, y});
      const bold = document.createElement("b");
      bold.textContent = text;
      told.append(told.childNodes.length ? ";  " : "", `${name} `, bold);
    }
  }

  function tapped(x, y) {
    tell(x, y);
    if (!curves) return;
    const far = data.rows.map((row) => Math.abs(row - y));
    showRow(far.indexOf(Math.min(...far)));
    const line = curves.center.find((one) => one.name === "place");
    line.location = x;
    line.visible = true;
  }

  async function start() {
    const items = [{docid: "plane", root_ids: roots, roots: Object.fromEntries(roots.map((id, i) => [id, places[i]]))}];
    await Bokeh.embed.embed_items({plane: data.document}, items);
    [map, curves] = Bokeh.documents[0].roots();
    for (const button of all("#layers button"))
      button.addEventListener("click", () => showLayer(button.dataset.layer));
    for (const button of all("#rows button")) button.addEventListener("click", () => showRow(Number(button.dataset.row)));
    narrow.addEventListener("change", () => showLayer(shown));
    showLayer(shown);
    if (curves) showRow(data.rows.length >> 1);
    document.body.dataset.ready = "true";
  }

  start();
  return {tapped};
})();
globalThis.bevelmap = bevelmap;
