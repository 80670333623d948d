"use strict";
// Light, dark, or as the system has it; figures that enlarge; motion that can be stopped.

const make = (tag, words, act) => {
  const made = document.createElement(tag);
  if (words) made.textContent = words;
  if (act) made.addEventListener("click", act);
  if (tag === "button") made.type = "button";
  return made;
};
const kept = {
  get: () => { try { return localStorage.getItem("theme"); } catch { return null; } },
  set: (name) => { try { localStorage.setItem("theme", name); } catch { /* a reader who keeps nothing */ } },
};

const themes = ["system", "light", "dark"];
const button = document.querySelector(".theme");
const wear = (name) => {
  if (name === "system") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = name;
  button.textContent = `Theme: ${name}`;
};
let theme = themes.includes(kept.get()) ? kept.get() : "system";
wear(theme);
button.hidden = false;
button.addEventListener("click", () => {
  theme = themes[(themes.indexOf(theme) + 1) % themes.length];
  kept.set(theme);
  wear(theme);
});

if (innerWidth < 640) document.querySelector(".contents details").open = false;

const dialog = make("dialog");
const stage = dialog.appendChild(make("div"));
stage.className = "stage";
const enlarged = stage.appendChild(make("img"));
const fit = () => Math.min(innerWidth, innerHeight * enlarged.naturalWidth / enlarged.naturalHeight);
const size = (width) => {
  const [x, y] = [stage.scrollLeft + stage.clientWidth / 2, stage.scrollTop + stage.clientHeight / 2];
  const before = enlarged.width || width;
  enlarged.style.width = `${Math.max(fit(), Math.min(width, 8 * fit()))}px`;
  const ratio = enlarged.width / before;
  stage.scrollTo(x * ratio - stage.clientWidth / 2, y * ratio - stage.clientHeight / 2);
};
const tools = dialog.appendChild(make("div"));
tools.className = "tools";
tools.append(
  make("button", "−", () => size(enlarged.width / 1.5)),
  make("button", "+", () => size(enlarged.width * 1.5)),
  make("button", "Close", () => dialog.close()),
);
stage.addEventListener("wheel", (event) => {
  event.preventDefault();
  size(enlarged.width * Math.exp(-event.deltaY / 400));
}, { passive: false });
stage.addEventListener("click", (event) => { if (event.target === stage) dialog.close(); });
document.body.append(dialog);

const open = (image) => {
  enlarged.src = image.src;
  enlarged.alt = image.alt;
  enlarged.decode().then(() => { dialog.showModal(); size(innerWidth < 700 ? 2 * fit() : fit()); stage.scrollTo(0, 0); });
};
for (const image of document.querySelectorAll(".picture img")) {
  image.classList.add("zoomable");
  image.tabIndex = 0;
  image.setAttribute("role", "button");
  image.addEventListener("click", () => open(image));
  image.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); open(image); } });
}

for (const picture of document.querySelectorAll(".moves")) {
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) continue;
  const stop = make("button", "Show stills", () => {
    stop.textContent = picture.classList.toggle("stopped") ? "Show motion" : "Show stills";
  });
  stop.className = "motion";
  picture.after(stop);
}
