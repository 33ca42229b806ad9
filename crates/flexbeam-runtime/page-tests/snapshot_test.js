import { csv, single } from "../page/snapshot_csv.js";
import { fileName } from "../page/snapshot.js";
import { ScopeCard } from "../page/scope_card.js";
import { Store } from "../page/store.js";
import { check, frameOf, laidOut, near, random, same, SIGNALS } from "./check.js";
import { png, svg } from "../page/snapshot.js";

export function csvReadsBackToTheBit() {
  const draw = random(2);
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  const rows = Array.from({ length: 3000 }, (_, k) => [
    k + 5,
    Math.fround((draw() - 0.5) * 10 ** ((k % 20) - 10)),
    Math.fround(k),
  ]);
  store.push(frameOf(rows));
  const lines = csv(store, ["psi_rad", "voltage_v"], 100, 2000).trimEnd().split("\n");
  same(lines[0], "time_s,psi_rad,voltage_v", "header");
  same(lines.length, 1901, "lines");
  lines.slice(1).forEach((line, k) => {
    const [time, psi, voltage] = line.split(",").map(Number);
    same(
      [time, Math.fround(psi), voltage],
      [Number(((100 + k) / 1000).toPrecision(15)), rows[95 + k][1], rows[95 + k][2]],
      `line ${k + 2}`,
    );
  });
}

export function numbersAreShortest() {
  same(
    [0.1, -1e-10, 3, 16777216, 1 / 3].map((x) => single(Math.fround(x))),
    ["0.1", "-1e-10", "3", "16777216", "0.33333334"],
    "texts",
  );
  same([NaN, Infinity, -Infinity].map(single), ["NaN", "inf", "-inf"], "not finite");
}

export function csvSaysWhatItLacks() {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  for (let tick = 0; tick < 140_000; tick += 4000) store.push(frameOf(Array.from({ length: 4000 }, (_, k) => [tick + k, k, 0])));
  const old = store.tickAt(store.rawFirst);
  const lines = csv(store, ["psi_rad"], 0, 140_000).split("\n");
  same(lines[0], `# raw samples reach back to ${old / 1000} s only; the plot begins at 0 s`, "comment");
  same(lines[2].split(",")[0], String(old / 1000), "first time");
  same(csv(store, ["psi_rad"], old + 5, old + 7).split("\n").length, 4, "no comment when all is there");
}

export function namesArePlain() {
  same(fileName("Tip angle: \u03c8 (\u00b0)", new Date(2026, 0, 2, 3, 4, 5), "svg"), "tip-angle_2026-01-02_030405.svg", "name");
  same(fileName("\u03c8", new Date(2026, 0, 2, 3, 4, 5), "csv"), "scope_2026-01-02_030405.csv", "no letters");
}

/** A card on the page that has drawn a frame. */
async function shown(kind, title = "Tip <angle> & voltage") {
  const store = new Store({ signals: SIGNALS, period_s: 0.001 });
  store.push(
    frameOf(Array.from({ length: 12_000 }, (_, k) => [k, 0.26 * Math.sin(k / 400), 4 * Math.sin(k / 400 + 1) + (k % 7) / 30])),
  );
  const scope = { title, kind, signals: ["psi_rad", "voltage_v"], span_s: 10 };
  const card = new ScopeCard({ store, signals: SIGNALS, scope, period_s: 0.001, onchange() {}, onremove() {}, onmove() {} });
  card.element.style.cssText = "width: 800px; height: 420px";
  document.body.append(card.element);
  await laidOut(card);
  card.draw(1000);
  return card;
}

export async function svgIsWellFormedAndStandsAlone() {
  for (const kind of ["time", "xy", "spectrum"]) {
    const card = await shown(kind);
    const text = svg(card.sight(new Date(2026, 0, 2)));
    card.destroy();
    const file = new DOMParser().parseFromString(text, "image/svg+xml");
    check(!file.querySelector("parsererror"), `${kind}: ${file.querySelector("parsererror")?.textContent}`);
    check(!/NaN|undefined|Infinity|var\(/.test(text), `${kind}: ${/.{30}(NaN|undefined|Infinity|var\().{30}/.exec(text)?.[0]}`);
    check(!/href|url\((?!#clip)/.test(text), `${kind}: points to something else`);
    check(file.querySelector("title").textContent.startsWith("Tip <angle> & voltage, 2026-01-02"), "title");
    check(text.includes("DejaVu Sans"), "fonts are named");
  }
}

/** Pixels of a picture. */
async function pixels(source, width, height) {
  const image = new Image();
  image.src = URL.createObjectURL(source);
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  canvas.getContext("2d").drawImage(image, 0, 0, width, height);
  return canvas.getContext("2d").getImageData(0, 0, width, height).data;
}

/** Pixels of either picture that nothing within a pixel of the other is like: rasters may smooth edges differently. */
function strange(a, b, width, height) {
  const alike = (i, j) => Math.abs(a[i] - b[j]) + Math.abs(a[i + 1] - b[j + 1]) + Math.abs(a[i + 2] - b[j + 2]) < 120;
  let count = 0;
  for (let y = 1; y < height - 1; y += 1) {
    for (let x = 1; x < width - 1; x += 1) {
      const i = 4 * (y * width + x);
      const around = [-1, 0, 1].flatMap((dy) => [-1, 0, 1].map((dx) => i + 4 * (dy * width + dx)));
      if (!around.some((j) => alike(i, j)) || !around.some((j) => alike(j, i))) count += 1;
    }
  }
  return count;
}

export async function svgAndPngAreTheSamePicture() {
  const said = [];
  for (const kind of ["time", "xy", "spectrum"]) {
    const card = await shown(kind, "Same");
    const sight = card.sight(new Date(2026, 0, 2));
    const text = svg(sight);
    const picture = await png(sight, 1);
    card.destroy();
    const [width, height] = [...text.matchAll(/(?:width|height)="(\d+)"/g)].slice(0, 2).map((m) => Number(m[1]));
    const [a, b] = [
      await pixels(picture, width, height),
      await pixels(new Blob([text], { type: "image/svg+xml" }), width, height),
    ];
    const share = strange(a, b, width, height) / (width * height);
    check(share < 3e-3, `${kind}: ${(share * 100).toFixed(3)} % of the pixels are not in the other picture`);
    said.push(`${kind} ${(share * 100).toFixed(3)} %`);
  }
  return `pixels that differ: ${said.join(", ")}`;
}

export async function cardKeepsItsScope() {
  const card = await shown("time");
  const scope = card.scope;
  scope.title = "changed outside";
  same(card.scope.title, "Tip <angle> & voltage", "a copy");
  card.take({ title: "New", kind: "spectrum", signals: ["voltage_v"], span_s: 4 });
  same(card.scope, { title: "New", kind: "spectrum", signals: ["voltage_v"], span_s: 4 }, "after the sheet");
  card.destroy();
  same(document.querySelectorAll(".scope").length, 0, "cards left");
}
