"use strict";
// Unpacks plotly.js and the data, draws the plots of the page, and plays the motion where it has one. One cursor goes
// through all plots with a clock: times of the trajectory or of the given motion, or the way along the path.
(async () => {
  const DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;,=>?@^_`{|}~";
  // what colours of a light page are on a dark one
  const DARK = {
    "#fff": "#15181c", "#ffffff": "#15181c", "#ffffffc0": "#15181cc0", "#1b1b1b": "#e4e6e8", "#000": "#f2f3f4",
    "#000000": "#f2f3f4", "#0072B2": "#4aa3df", "#e5e5e5": "#2b3036", "#eee": "#2b3036", "#e4e4e4": "#2b3036",
    "#ddd": "#3a4047", "#d9d9d9": "#4a525b", "#cfd3d8": "#3a4047", "#bbb": "#6d757e", "#555": "#a3abb4", "#666": "#a3abb4",
  };

  // base 85 of gzip, "," for "<"
  function unpacked(id) {
    const text = document.getElementById(id).textContent;
    const values = new Uint8Array(128);
    [...DIGITS].forEach((digit, value) => (values[digit.charCodeAt(0)] = value));
    const groups = Math.ceil(text.length / 5);
    const bytes = new DataView(new ArrayBuffer(4 * groups));
    for (let group = 0; group < groups; group += 1) {
      let value = 0;
      for (let at = 5 * group; at < 5 * group + 5; at += 1) value = 85 * value + (at < text.length ? values[text.charCodeAt(at)] : 84);
      bytes.setUint32(4 * group, value);
    }
    const whole = new Blob([bytes.buffer.slice(0, 4 * groups - (5 * groups - text.length))]);
    return new Response(whole.stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }

  const script = document.createElement("script");
  script.textContent = await unpacked("plot-library");
  document.head.append(script);
  const report = JSON.parse(await unpacked("report-data"));

  // named one by one: plotly's own choice has a button that would upload the chart
  const config = (...buttons) => ({ responsive: true, displaylogo: false, modeBarButtons: [["toImage", ...buttons]] });
  const system = matchMedia("(prefers-color-scheme: dark)");
  const root = document.documentElement;
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : system.matches);

  // plots are drawn for a light page; a dark one maps the values of keys that are colours
  function coloured(value, dark, key = "") {
    if (!dark) return value;
    if (typeof value === "string") {
      if (key === "ticktext") return value.replace(/^<span style="color:(#\w+)/, (all, colour) => all.replace(colour, DARK[colour] ?? colour));
      return /color(s|scale)?$/.test(key) ? DARK[value] ?? value : value;
    }
    if (Array.isArray(value)) return /^([ixyzjk]|text|customdata|values)$/.test(key) ? value : value.map((each) => coloured(each, dark, key));
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([name, each]) => [name, coloured(each, dark, name)]));
  }

  const plots = Object.entries(report.plots).map(([name, plot]) => ({ ...plot, place: document.getElementById(name) }));
  // a legend that takes more lines makes its plot higher, so that no curve gets less room
  function grow({ place, layout, panels }) {
    const height = panels + (place._fullLayout.legend?._height ?? 0);
    if (Math.abs(height - layout.height) < 2) return;
    layout.height = height;
    place.style.height = `${height}px`;
    Plotly.relayout(place, { height, autosize: true }); // a height alone would end its following the page's width
  }
  for (const plot of plots) {
    plot.layout.uirevision = "kept";
    plot.panels = plot.layout.height;
    await Plotly.newPlot(plot.place, coloured(plot.data, isDark()), coloured(plot.layout, isDark()), config("zoom2d", "pan2d", "resetScale2d"));
    grow(plot);
    plot.place.on("plotly_afterplot", () => grow(plot));
  }

  const player = report.player && { ...report.player, place: document.getElementById("player"), frame: 0 };

  function paint(plot, dark, size = {}) {
    const data = plot === player ? moved(plot.frame) : plot.data;
    return Plotly.react(plot.place, coloured(data, dark), { ...coloured(plot.layout, dark), ...size });
  }

  function moved(frame) {
    return player.data.map((trace, index) => {
      const own = player.frames[index];
      return own ? { ...trace, x: own.x[frame], y: own.y[frame], z: own.z[frame] } : trace;
    });
  }

  const painted = () => (player ? [player, ...plots] : plots);
  const button = document.getElementById("theme");
  function themed() {
    button.textContent = isDark() ? "Light" : "Dark";
    painted().forEach((plot) => paint(plot, isDark()));
  }
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    themed();
  });
  system.addEventListener("change", themed);
  button.textContent = isDark() ? "Light" : "Dark";
  button.hidden = false;

  // paper is light and as wide as .printing; what is drawn by the graphics card is printed as a picture of it
  let theme = null;
  let pictures = [];
  window.addEventListener("beforeprint", () => {
    theme = root.dataset.theme ?? "";
    root.dataset.theme = "light";
    document.body.classList.add("printing");
    for (const plot of painted()) {
      const { clientWidth: width, clientHeight: height } = plot.place;
      const size = plot === player ? { width, height, scene: { ...plot.layout.scene, aspectratio: fit(metres) } } : { width, height };
      paint(plot, false, size);
      const legend = plot.place._fullLayout.legend?._height; // may have more lines now; plotly makes room only later
      if (legend && plot !== player) paint(plot, false, { ...size, margin: { ...plot.layout.margin, t: plot.layout.margin.t + legend } });
    }
    for (const drawn of player ? player.place.querySelectorAll("canvas") : []) {
      player.place._fullLayout.scene._scene.glplot.redraw();
      const picture = document.createElement("canvas");
      picture.width = drawn.width;
      picture.height = drawn.height;
      picture.style.cssText = drawn.style.cssText;
      picture.className = "picture";
      picture.getContext("2d").drawImage(drawn, 0, 0);
      drawn.after(picture);
      drawn.hidden = true;
      pictures.push([drawn, picture]);
    }
  });
  window.addEventListener("afterprint", () => {
    if (theme) root.dataset.theme = theme;
    else delete root.dataset.theme;
    document.body.classList.remove("printing");
    pictures.forEach(([drawn, picture]) => {
      picture.remove();
      drawn.hidden = false;
    });
    pictures = [];
    painted().forEach((plot) => paint(plot, isDark(), { autosize: true }));
  });

  document.getElementById("drawing").remove();
  if (!player) {
    document.body.dataset.ready = "yes";
    return;
  }

  const { layout, frames, time, speed, clocks } = player;
  const slider = document.getElementById("frame");
  const play = document.getElementById("play");
  const now = document.getElementById("now");
  const rate = document.getElementById("speed");
  const traces = frames.map((_, index) => index);
  const end = time[time.length - 1];
  let clock = 0;
  let before = 0;
  let tick = null;
  let held = false;

  // where a clock is at a frame between two, and back
  const between = (values, frame) => {
    const at = Math.min(Math.floor(frame), values.length - 2);
    return values[at] + (frame - at) * (values[at + 1] - values[at]);
  };
  function frameAt(values, value) {
    const after = values.findIndex((each) => each >= value);
    if (after <= 0) return after < 0 ? values.length - 1 : 0;
    const step = values[after] - values[after - 1];
    return after - (step > 0 ? (values[after] - value) / step : 0);
  }

  const timed = plots.filter((plot) => plot.clock);
  let pointed = 0;
  function point(frame) {
    pointed = frame;
    for (const { place, clock: name, cursor } of timed) {
      const { xaxis, _size: size } = place._fullLayout;
      const x = xaxis.d2p(between(clocks[name], frame));
      cursor.hidden = !(x >= 0 && x <= size.w);
      cursor.style.transform = `translateX(${x}px)`;
    }
  }
  function place({ place: { _fullLayout: { _size: size } }, cursor }) {
    cursor.style.cssText = `left:${size.l}px;top:${size.t}px;height:${size.h}px`;
    point(pointed);
  }
  for (const plot of timed) {
    plot.cursor = document.createElement("div");
    plot.cursor.className = "cursor";
    plot.place.append(plot.cursor);
  }
  for (const plot of timed) {
    place(plot);
    plot.place.on("plotly_afterplot", () => place(plot));
    plot.place.on("plotly_hover", ({ xvals }) => {
      if (tick !== null || typeof xvals?.[0] !== "number") return;
      const frame = frameAt(clocks[plot.clock], xvals[0]);
      show(Math.round(frame), frame);
    });
  }

  function show(frame, exact = frame) {
    slider.value = frame;
    const at = between(time, exact);
    now.textContent = `${at.toPrecision(3)} s of ${end.toPrecision(3)} s`;
    point(exact);
    if (frame === player.frame) return;
    player.frame = frame;
    const of = (axis) => frames.map((trace) => trace[axis][frame]);
    Plotly.restyle(player.place, { x: of("x"), y: of("y"), z: of("z") }, traces);
  }

  function step(stamp) {
    if (!held) clock += (Math.max(stamp - before, 0) / 1000) * Number(rate.value);
    before = stamp;
    let frame = player.frame;
    while (frame + 1 < time.length && time[frame + 1] <= clock) frame += 1;
    if (!held) show(frame, frameAt(time, clock));
    if (frame + 1 < time.length) tick = requestAnimationFrame(step);
    else stop();
  }

  function stop() {
    cancelAnimationFrame(tick);
    tick = null;
    play.textContent = "Play";
  }

  function start() {
    if (player.frame + 1 >= time.length) show(0);
    clock = time[player.frame];
    play.textContent = "Pause";
    before = performance.now();
    tick = requestAnimationFrame(step);
  }

  // plotly shows about two units upward, and as many more sideways as the window is wider than high
  function fit({ aspectratio: size, camera }) {
    const axes = Object.keys(size);
    const upward = axes.reduce((best, axis) => (Math.abs(camera.up[axis]) > Math.abs(camera.up[best]) ? axis : best));
    const wide = Math.hypot(...axes.filter((axis) => axis !== upward).map((axis) => size[axis]));
    const high = size[upward] + wide / 2;
    const scale = 1.4 * Math.min(1 / high, player.place.clientWidth / player.place.clientHeight / wide);
    return Object.fromEntries(axes.map((axis) => [axis, size[axis] * scale]));
  }

  const metres = layout.scene;
  layout.scene = { ...metres, aspectratio: fit(metres) };
  await Plotly.newPlot(player.place, coloured(player.data, isDark()), coloured(layout, isDark()), config("tableRotation", "pan3d", "resetCameraDefault3d"));
  show(0);
  play.addEventListener("click", () => (tick === null ? start() : stop()));
  slider.addEventListener("input", () => {
    stop();
    show(Number(slider.value));
  });
  // the camera belongs to the reader while a button is down
  player.place.addEventListener("pointerdown", () => (held = true), true);
  window.addEventListener("pointerup", () => (held = false), true);
  window.addEventListener("pointercancel", () => (held = false), true);
  window.addEventListener("resize", () => {
    layout.scene = { ...layout.scene, aspectratio: fit(metres) };
    Plotly.relayout(player.place, { "scene.aspectratio": fit(metres) });
  });
  document.body.dataset.ready = "yes";
})();
