"use strict";
// Draws the plots of the page, and plays the motion where it has one; all data stand in the element #report-data.
(() => {
  const report = JSON.parse(document.getElementById("report-data").textContent);
  // named one by one: plotly's own choice has a button that would upload the chart
  const config = (...buttons) => ({ responsive: true, displaylogo: false, modeBarButtons: [["toImage", ...buttons]] });
  const drawn = Object.entries(report.plots).map(([name, plot]) =>
    Plotly.newPlot(name, plot.data, plot.layout, config("zoom2d", "pan2d", "resetScale2d")),
  );
  const resize = () => document.querySelectorAll(".js-plotly-plot").forEach((plot) => Plotly.Plots.resize(plot));
  window.addEventListener("beforeprint", resize);
  window.addEventListener("afterprint", resize);
  if (!report.player) {
    Promise.all(drawn).then(() => (document.body.dataset.ready = "yes"));
    return;
  }

  const { data, layout, frames, time, speed } = report.player;
  const scene = document.getElementById("player");
  const button = document.getElementById("play");
  const slider = document.getElementById("frame");
  const now = document.getElementById("now");
  const rate = document.getElementById("speed");
  const traces = frames.map((_, index) => index);
  const end = time[time.length - 1];
  let shown = 0;
  let clock = 0;
  let before = 0;
  let tick = null;
  let held = false;

  function show(frame) {
    slider.value = frame;
    now.textContent = `${time[frame].toPrecision(3)} s of ${end.toPrecision(3)} s`;
    if (frame === shown) return;
    shown = frame;
    const at = (axis) => frames.map((trace) => trace[axis][frame]);
    Plotly.restyle(scene, { x: at("x"), y: at("y"), z: at("z") }, traces);
  }

  function step(stamp) {
    if (!held) clock += (Math.max(stamp - before, 0) / 1000) * Number(rate.value);
    before = stamp;
    let frame = shown;
    while (frame + 1 < time.length && time[frame + 1] <= clock) frame += 1;
    if (!held) show(frame);
    if (frame + 1 < time.length) tick = requestAnimationFrame(step);
    else stop();
  }

  function stop() {
    cancelAnimationFrame(tick);
    tick = null;
    button.textContent = "Play";
  }

  function start() {
    if (shown + 1 >= time.length) show(0);
    clock = time[shown];
    button.textContent = "Pause";
    before = performance.now();
    tick = requestAnimationFrame(step);
  }

  // plotly shows about two units upward, and as many more sideways as the window is wider than high
  function fit({ aspectratio: size, camera }) {
    const flat = camera.projection.type === "orthographic";
    const axes = Object.keys(size);
    const upward = axes.reduce((best, axis) => (Math.abs(camera.up[axis]) > Math.abs(camera.up[best]) ? axis : best));
    const level = axes.filter((axis) => axis !== upward);
    const wide = Math.hypot(...level.filter((axis) => !flat || camera.eye[axis] === 0).map((axis) => size[axis]));
    const high = size[upward] + (flat ? 0 : wide / 2);
    const scale = (flat ? 1.6 : 1.4) * Math.min(1 / high, scene.clientWidth / scene.clientHeight / wide);
    return Object.fromEntries(axes.map((axis) => [axis, size[axis] * scale]));
  }

  const metres = layout.scene;
  layout.scene = { ...metres, aspectratio: fit(metres) };
  Plotly.newPlot(scene, data, layout, config("tableRotation", "pan3d", "resetCameraDefault3d")).then(() => {
    show(0);
    button.addEventListener("click", () => (tick === null ? start() : stop()));
    slider.addEventListener("input", () => {
      stop();
      show(Number(slider.value));
    });
    // the camera belongs to the reader while a button is down
    scene.addEventListener("pointerdown", () => (held = true), true);
    window.addEventListener("pointerup", () => (held = false), true);
    window.addEventListener("pointercancel", () => (held = false), true);
    window.addEventListener("resize", () => Plotly.relayout(scene, { "scene.aspectratio": fit(metres) }));
    document.body.dataset.ready = "yes";
  });
})();
