"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const id = (name) => document.getElementById(name);
  const config = { responsive: true, displaylogo: false, displayModeBar: false };
  const font = { family: "system-ui, 'Segoe UI', 'Liberation Sans', Arial, sans-serif", size: 13, color: "#1a1a1a" };
  // Dark colours and different dashes: the curves can be told apart without colour.
  const inks = ["#000000", "#0072b2", "#d55e00", "#009e73", "#8a3d7a", "#7a6a00"];
  const dashes = ["solid", "dash", "dashdot", "longdash", "dot", "longdashdot"];

  const show = (x) => Number(x.toPrecision(3)).toString();

  // ---- curves --------------------------------------------------------------------------------
  const curve = (name, y, i, more) =>
    ({ type: "scatter", mode: "lines", name, x: data.curves.time, y, line: { color: inks[i % 6], dash: dashes[i % 6], width: 2 }, ...more });
  const axes = (title, more) => ({
    font, margin: { l: 85, r: 15, t: 50, b: 50 }, paper_bgcolor: "#fff", plot_bgcolor: "#fff",
    showlegend: true, legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
    xaxis: { title: { text: "time" + data.time_unit }, gridcolor: "#e4e4e4", linecolor: "#888", zeroline: false, ticks: "outside" },
    yaxis: { title: { text: title }, gridcolor: "#e4e4e4", linecolor: "#888", zerolinecolor: "#aaa", exponentformat: "power", automargin: true, ticks: "outside", ...more },
  });

  function drawProbes() {
    const plots = new Map();
    data.probes.forEach((p, k) => {
      const key = p.plot + p.unit;
      if (!plots.has(key)) plots.set(key, { title: p.plot.replaceAll("_", " ") + p.unit, traces: [] });
      const traces = plots.get(key).traces;
      traces.push(curve(p.name, data.curves.probes[k], traces.length));
    });
    const moved = data.force_displacement.filter((c) => data.curves.probes[c.displacement].some((u) => u));
    if (moved.length) {
      const traces = moved.map((c, i) => curve(c.name, data.curves.probes[c.force], i, { x: data.curves.probes[c.displacement] }));
      plots.set("force over displacement", { title: "force" + data.force_unit, over: "displacement" + data.length_unit, traces });
    }
    // All places first: a plot takes the width that its place has when it is drawn.
    const places = [...plots.values()].map((plot) => {
      const div = document.createElement("div");
      div.className = "plot";
      id("probes").append(div);
      return { div, ...plot };
    });
    for (const { div, title, over, traces } of places) {
      const layout = axes(title);
      if (over) layout.xaxis.title.text = over;
      Plotly.newPlot(div, traces, layout, config);
    }
    if (!plots.size) id("probes").textContent = "The scenario has no probe.";
  }

  function drawConservation() {
    const c = data.curves;
    const sum = c.kinetic.map((k, i) => k + c.elastic[i] + c.dissipated[i]);
    Plotly.newPlot("energy", [
      curve("work", c.external_work, 0, {}),
      curve("elastic", c.elastic, 1), curve("dissipated", c.dissipated, 2), curve("kinetic", c.kinetic, 3),
      curve("sum of the three", sum, 4, { line: { color: "#777", dash: "dot", width: 4 } }),
    ], axes("energy" + data.energy_unit), config);
    // A logarithm has no place for an exact zero.
    const positive = (v) => v.map((x) => (x > 0 ? x : null));
    const [momentum, mass] = [positive(c.momentum_error), positive(c.mass_error)];
    const exact = (v) => (v.every((x) => x === null) ? " (exactly 0)" : "");
    Plotly.newPlot("errors", [
      curve("momentum" + exact(momentum), momentum, 0), curve("mass" + exact(mass), mass, 1),
    ], axes("relative error", { type: "log", dtick: 1, range: logRange([...momentum, ...mass]) }), config);
  }

  /// Whole powers of ten around the values, at least two of them.
  function logRange(values) {
    const logs = values.filter((v) => v !== null).map(Math.log10);
    if (!logs.length) return [-17, -15];
    const low = Math.floor(logs.reduce((a, b) => Math.min(a, b)));
    return [low, Math.max(low + 2, Math.ceil(logs.reduce((a, b) => Math.max(a, b)) + 0.1))];
  }

  // ---- packed arrays -------------------------------------------------------------------------
  function bytes(text) {
    const raw = atob(text), out = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
    return out.buffer;
  }
  const unpacked = new Map();
  function numbers(packed) {
    if (!unpacked.has(packed)) {
      const step = (packed.high - packed.low) / 65534;
      unpacked.set(packed, Float32Array.from(new Uint16Array(bytes(packed.codes)), (c) => (c === 65535 ? NaN : packed.low + step * c)));
    }
    return unpacked.get(packed);
  }

  // ---- the surface ---------------------------------------------------------------------------
  const { meshes, frames } = data.view;
  const known = [
    ["normal_strain", "normal strain n·e·n", "", true],
    ["shear_strain", "shear strain |e n − (n·e·n) n|", "", false],
    ["displacement", "displacement, magnitude", data.length_unit, false],
    ["von_mises", "von Mises stress", data.stress_unit, false],
    ["material", "number of the material", "", false],
    ["velocity_x", "velocity along x", data.velocity_unit, true],
    ["volume_ratio", "volume ratio det F", "", "around 1"],
    ["principal_stretch_1", "largest principal stretch", "", "around 1"],
    ["principal_strain_1", "largest principal strain", "", true],
    ["principal_strain_3", "smallest principal strain", "", true],
    ["max_shear_strain", "maximum shear strain (e₁ − e₃)/2", "", false],
    ["principal_stress_1", "largest principal stress", data.stress_unit, true],
    ["principal_stress_3", "smallest principal stress", data.stress_unit, true],
    ["max_shear_stress", "maximum shear stress (σ₁ − σ₃)/2", data.stress_unit, false],
    ["pressure", "pressure −tr σ/3", data.stress_unit, true],
  ];
  const has = (f, key) => (key === "displacement" ? f.u !== null : key in f.scalars);
  const fields = known.filter(([key]) => frames.length && frames.every((f) => has(f, key)));
  const maps = {
    Viridis: "Viridis",
    gray: [[0, "#1c1c1c"], [1, "#ffffff"]],
    diverging: [[0, "#2166ac"], [0.25, "#92c5de"], [0.5, "#f7f7f7"], [0.75, "#f4a582"], [1, "#b2182b"]],
  };

  function values(frame, key) {
    if (key !== "displacement") return numbers(frame.scalars[key]);
    const [x, y, z] = frame.u.map(numbers);
    return x.map((v, i) => Math.hypot(v, y[i], z[i]));
  }
  const extent = (v) => {
    let low = Infinity, high = -Infinity;
    for (const x of v) { if (x < low) low = x; if (x > high) high = x; }
    return [low, high];
  };

  /// One range of colours for all frames, without the outermost 0.5 % of the values.
  const ranges = new Map();
  function range(key, around) {
    const middle = around === "around 1" ? 1 : 0, symmetric = Boolean(around);
    if (!ranges.has(key)) {
      const all = [];
      for (const f of frames) {
        const v = values(f, key), skip = Math.max(1, Math.floor((v.length * frames.length) / 2e5));
        for (let i = 0; i < v.length; i += skip) if (!Number.isNaN(v[i])) all.push(symmetric ? Math.abs(v[i] - middle) : v[i]);
      }
      const sorted = Float64Array.from(all).sort();
      const top = sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(0.995 * sorted.length))] : 0;
      const high = top > 0 ? top : 1;
      ranges.set(key, symmetric ? [middle - high, middle + high] : [0, high]);
    }
    return ranges.get(key);
  }

  function drawView() {
    const still = meshes.map((m) => m.x.map(numbers));
    const triangles = meshes.map((m) => {
      const flat = new Uint32Array(bytes(m.triangles)), corner = (c) => flat.filter((_, k) => k % 3 === c);
      return { i: corner(0), j: corner(1), k: corner(2) };
    });
    const boxes = frames.map((f) => [0, 1, 2].map((c) => [extent(still[f.mesh][c]), f.u ? extent(numbers(f.u[c])) : [0, 0]]));
    const size = Math.max(...boxes.flatMap((b) => b.map(([x]) => x[1] - x[0])));
    let largest = 0;
    if (fields.some(([key]) => key === "displacement")) {
      for (const f of frames) largest = Math.max(largest, extent(values(f, "displacement"))[1]);
    }
    const nice = (x) => { const p = 10 ** Math.floor(Math.log10(x)), m = x / p; return (m >= 5 ? 5 : m >= 2 ? 2 : 1) * p; };
    const wanted = largest > 0 ? (0.1 * size) / largest : 1;
    const start = wanted <= 1 ? 1 : nice(Math.min(wanted, 10000));
    const state = { frame: frames.length - 1, factor: start, field: fields[0], map: "Viridis", up: data.up };

    /// The corner points of everything that can be seen at this factor: the axes do not jump.
    function limits() {
      return [0, 1, 2].map((c) => {
        let low = Infinity, high = -Infinity;
        for (const b of boxes) {
          const [x, u] = b[c];
          low = Math.min(low, x[0], x[0] + state.factor * u[0]);
          high = Math.max(high, x[1], x[1] + state.factor * u[1]);
        }
        const margin = 0.03 * size;
        return [low - margin, high + margin];
      });
    }
    function scene() {
      const box = limits(), spans = box.map(([a, b]) => b - a), longest = Math.max(...spans);
      const axis = (name, c) => ({ title: { text: name + data.length_unit }, range: box[c], backgroundcolor: "#fff", gridcolor: "#ddd", showspikes: false, nticks: 5 });
      return {
        xaxis: axis("x", 0), yaxis: axis("y", 1), zaxis: axis("z", 2), aspectmode: "manual",
        aspectratio: { x: spans[0] / longest, y: spans[1] / longest, z: spans[2] / longest },
      };
    }
    const narrow = () => window.innerWidth < 640;
    const cameras = {
      x: { up: { x: 1, y: 0, z: 0 }, eye: { x: 0.8, y: 1.3, z: 1.4 } },
      y: { up: { x: 0, y: 1, z: 0 }, eye: { x: 0.6, y: 0.7, z: -1.8 } },
      z: { up: { x: 0, y: 0, z: 1 }, eye: { x: 1.35, y: -1.5, z: 0.75 }, center: { x: 0, y: 0, z: -0.1 } },
    };
    const poseOf = (up) => ({ camera: cameras[up], dragmode: up === "z" ? "turntable" : "orbit" });
    let pose = poseOf(data.up);
    function trace() {
      const f = frames[state.frame], x = still[f.mesh], u = f.u ? f.u.map(numbers) : null;
      const place = (c) => (u ? x[c].map((v, i) => v + state.factor * u[c][i]) : x[c]);
      const t = { type: "mesh3d", x: place(0), y: place(1), z: place(2), ...triangles[f.mesh], flatshading: false,
        lighting: { ambient: 0.72, diffuse: 0.45, specular: 0.04, roughness: 0.9, fresnel: 0 }, hoverinfo: "x+y+z" };
      if (!state.field) return { ...t, color: "#bbbbbb" };
      const [key, label, unit, around] = state.field, [cmin, cmax] = range(key, around), v = values(f, key);
      return { ...t, intensity: v, cmin, cmax, colorscale: maps[state.map],
        hovertext: Array.from(v, (x) => label + unit + ": " + show(x)), hoverinfo: "x+y+z+text",
        colorbar: narrow()
          ? { title: { text: label + unit, side: "top" }, orientation: "h", y: -0.02, yanchor: "top", thickness: 12, nticks: 5, exponentformat: "power" }
          : { title: { text: label + unit, side: "right" }, thickness: 16, len: 0.85, exponentformat: "power" } };
    }
    const layout = () => ({ font, margin: { l: 0, r: 0, t: 0, b: narrow() ? 70 : 0 }, scene: { ...scene(), ...pose } });
    function draw() {
      Plotly.react("view", [trace()], layout(), { ...config, displayModeBar: true });
      id("time").textContent = "t = " + show(frames[state.frame].time) + data.time_unit.replace(/[[\]]/g, "");
      id("frame").value = state.frame;
      id("factor").value = Math.min(state.factor, Number(id("factor").max));
      id("exact").value = Number(state.factor.toPrecision(3));
      const largestText = largest > 0 ? "Largest displacement of the run: " + show(largest) + data.length_unit.replace(/[[\]]/g, "") + ". " : "";
      const drawn = frames.some((f) => f.u) ? "Drawn displacement: " + show(state.factor) + " × the computed one (0: undeformed, 1: true). " : "";
      const coloured = fields.length ? "One range of colours for all frames, without the outermost 0.5 % of the values." : "";
      id("range").textContent = largestText + drawn + coloured;
    }
    // Whoever turned the view keeps it that way from frame to frame.
    const keep = () => { const { camera, dragmode } = id("view").layout.scene; pose = { camera, dragmode }; };
    let waiting = false;
    function update(change) {
      Object.assign(state, change);
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(() => { waiting = false; draw(); });
    }

    // What there is nothing to choose from is not offered.
    for (const control of ["field", "map"]) id(control).parentElement.hidden = !fields.length;
    id("factor").parentElement.hidden = !frames.some((f) => f.u);
    fields.forEach(([, label], i) => id("field").add(new Option(label, i)));
    id("frame").max = frames.length - 1;
    id("factor").max = largest > 0 ? 4 * start : 1;
    id("up").value = data.up;
    id("field").onchange = (e) => update({ field: fields[e.target.value] });
    id("map").onchange = (e) => update({ map: e.target.value });
    id("up").onchange = (e) => { pose = poseOf(e.target.value); update({ up: e.target.value }); };
    id("frame").oninput = (e) => update({ frame: Number(e.target.value) });
    id("factor").oninput = (e) => update({ factor: Number(e.target.value) });
    id("exact").onchange = (e) => { if (Number(e.target.value) >= 0) update({ factor: Number(e.target.value) }); };
    let timer = null;
    id("play").onclick = () => {
      if (timer) { clearInterval(timer); timer = null; } else {
        timer = setInterval(() => update({ frame: (state.frame + 1) % frames.length }), 200);
      }
      id("play").textContent = timer ? "■" : "▶";
    };
    id("controls").hidden = false;
    draw();
    id("view").on("plotly_relayout", keep);
  }

  drawProbes();
  drawConservation();
  if (frames.length) drawView(); else id("view").remove();
})();
