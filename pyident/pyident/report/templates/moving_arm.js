// The arm that was measured, solid, and the one that was simulated, as a ghost; keyframes play in the browser.
// Deformations and misses are drawn s times their size: rigid pose + s (pose − rigid pose).
// "flexident-time" tells other figures the time that is shown; "flexident-seek" asks for another.
function flexidentArm(root, data) {
  const frames = data.time.length, last = data.time[frames - 1], began = data.time[0];
  const ghost = data.simulated.length > 0;
  root.innerHTML = `<canvas data-testid="arm" tabindex="0" role="img" aria-label="${data.label}"
      style="width:100%;height:${data.height}px;touch-action:none;cursor:grab;border:1px solid #d5d9dd"></canvas>
    <div style="display:${frames < 2 ? "none" : "flex"};flex-wrap:wrap;gap:.6rem;align-items:center;font-size:.9rem">
      <button type="button" data-testid="play" style="border:1px solid #59616b;border-radius:4px;padding:.1rem .7rem"
        >Play</button>
      <input type="range" data-testid="moment" aria-label="time" min="0" max="1000" value="0" style="flex:1 1 8rem">
      <output data-testid="arm-time" style="min-width:5.5rem"></output>
      <label>deformation × <input type="range" data-testid="exaggeration" min="0" max="1000" value="0"
        style="vertical-align:middle"> <output data-testid="times">1</output></label>
    </div>`;
  const find = name => root.querySelector(`[data-testid="${name}"]`);
  const canvas = find("arm"), button = find("play"), moment = find("moment"), slider = find("exaggeration");
  const context = canvas.getContext("2d");
  let time = began, turn = -0.9, tilt = 0.45, loop = 0, size = 1;
  const all = data.rigid.flat().concat([[0, 0, 0]]);
  const middle = [0, 1, 2].map(i => (Math.min(...all.map(p => p[i])) + Math.max(...all.map(p => p[i]))) / 2);
  const widest = Math.max(...all.map(p => Math.hypot(...p.map((v, i) => v - middle[i]))));
  const reach = 1.15 * widest || 1;  // a slide that stands at the origin is a point

  const at = (motion, deltas) => {
    const x = frames < 2 ? 0 : (time - began) / (last - began) * (frames - 1);
    const i = Math.min(Math.floor(x), Math.max(frames - 2, 0)), j = Math.min(i + 1, frames - 1), f = x - i;
    return motion[i].map((p, k) => p.map((v, c) => {
      const rigid = v + f * (motion[j][k][c] - v);
      if (!deltas) return rigid;
      return rigid + size * (deltas[i][k][c] + f * (deltas[j][k][c] - deltas[i][k][c]));
    }));
  };
  const seen = p => {
    const [x, y, z] = p.map((v, i) => v - middle[i]);
    const a = x * Math.cos(turn) - y * Math.sin(turn), b = x * Math.sin(turn) + y * Math.cos(turn);
    const half = Math.min(canvas.width, canvas.height) / 2 / reach;
    return [canvas.width / 2 + half * a, canvas.height / 2 - half * (z * Math.cos(tilt) - b * Math.sin(tilt)),
      b * Math.cos(tilt) + z * Math.sin(tilt)];
  };
  const line = (p, q, colour, width) => {
    context.strokeStyle = colour; context.lineWidth = width; context.lineCap = "round";
    context.beginPath(); context.moveTo(p[0], p[1]); context.lineTo(q[0], q[1]); context.stroke();
  };
  const ground = () => {
    const step = reach / 3;
    for (let i = -3; i <= 3; i++) {
      line(seen([i * step, -reach, 0]), seen([i * step, reach, 0]), "#e4e7ea", 1);
      line(seen([-reach, i * step, 0]), seen([reach, i * step, 0]), "#e4e7ea", 1);
    }
  };
  const arm = (points, solid) => {
    const unit = canvas.height / 60, drawn = points.map(seen), base = seen([0, 0, 0]);
    const parts = data.pairs.map(([from, to]) => ({ p: from < 0 ? base : drawn[from], q: drawn[to] }));
    parts.sort((a, b) => a.p[2] + a.q[2] - b.p[2] - b.q[2]);
    parts.forEach(({ p, q }) => line(p, q, solid ? "#8a949e" : data.ghost, solid ? unit : 0.7 * unit));
    drawn.forEach((p, k) => {
      context.fillStyle = solid ? data.colours[k] : data.ghost;
      context.beginPath();
      context.arc(p[0], p[1], (k < drawn.length - 1 ? 1.1 : 0.6) * unit, 0, 2 * Math.PI);
      context.fill();
      if (solid) { context.strokeStyle = "#1c2126"; context.lineWidth = 1.5; context.stroke(); }
    });
  };
  const draw = () => {
    const scale = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * scale; canvas.height = canvas.clientHeight * scale;
    ground();
    context.globalAlpha = 0.5;
    if (ghost) arm(at(data.rigid, data.simulated), false);
    context.globalAlpha = 1;
    arm(at(data.rigid, data.measured), true);
    find("arm-time").textContent = frames > 1 ? `${time.toFixed(2)} s` : "";
    find("times").textContent = size < 10 ? size.toFixed(1) : size.toFixed(0);
    root.dataset.time = time.toFixed(4);
  };
  const show = (seconds, told) => {
    time = Math.min(Math.max(seconds, began), last);
    moment.value = last > began ? 1000 * (time - began) / (last - began) : 0;
    draw();
    if (!told) document.dispatchEvent(new CustomEvent("flexident-time", { detail: { log: data.log, time } }));
  };
  const play = (on) => {
    const mine = ++loop;  // an older loop sees that it is over
    button.textContent = on ? "Pause" : "Play";
    let before = performance.now();
    const next = (now) => {
      if (mine !== loop || !root.isConnected) return;
      show(time >= last ? began : time + (now - before) / 1000);
      before = now;
      requestAnimationFrame(next);
    };
    if (on) requestAnimationFrame(next);
  };
  button.onclick = () => play(button.textContent === "Play");
  moment.oninput = () => { play(false); show(began + (last - began) * moment.value / 1000); };
  slider.oninput = () => { size = Math.pow(data.most, slider.value / 1000); draw(); };
  canvas.onpointerdown = (e) => canvas.setPointerCapture(e.pointerId);
  canvas.onpointermove = (e) => {
    if (!e.buttons) return;
    turn -= 0.01 * e.movementX; tilt = Math.min(Math.max(tilt + 0.01 * e.movementY, -1.5), 1.5); draw();
  };
  canvas.onkeydown = (e) => {
    const step = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[e.key];
    if (step) { turn += step[0]; tilt += step[1]; draw(); e.preventDefault(); }
  };
  const sought = (e) => {
    if (!root.isConnected) return document.removeEventListener("flexident-seek", sought);
    if (e.detail.log === data.log && button.textContent === "Play") show(e.detail.time, true);
  };
  document.addEventListener("flexident-seek", sought);
  new ResizeObserver(draw).observe(canvas);
  show(began, true);
}

// A line in a figure at the time that the arm shows; hovering over the figure moves the arm.
function flexidentCursor(plot, log) {
  const line = document.createElement("div");
  line.dataset.testid = "cursor";
  line.style.cssText = "position:absolute;width:1px;background:#2b6ca3;pointer-events:none;display:none;z-index:5";
  plot.style.position = "relative";
  plot.append(line);
  const draw = (e) => {
    if (!plot.isConnected) return document.removeEventListener("flexident-time", draw);
    const layout = plot._fullLayout;
    if (!layout || e.detail.log !== log) return;
    const x = layout.xaxis.l2p(e.detail.time);
    line.style.display = x < 0 || x > layout.xaxis._length ? "none" : "block";
    line.style.left = `${layout._size.l + x}px`;
    line.style.top = `${layout._size.t}px`;
    line.style.height = `${layout._size.h}px`;
  };
  document.addEventListener("flexident-time", draw);
  plot.on("plotly_hover", (e) => {
    const detail = { log, time: e.points[0].x };
    document.dispatchEvent(new CustomEvent("flexident-seek", { detail }));
    document.dispatchEvent(new CustomEvent("flexident-time", { detail }));
  });
}
