// node --experimental-wasm-relaxed-simd run.mjs FILE.wasm
import { readFileSync } from "node:fs";

// What the module imports is never called: it draws no random numbers.
const anything = { get: () => new Proxy({}, { get: (_, name) => () => { throw new Error(String(name)); } }) };
const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]), new Proxy({}, anything));
const { setup, steps, settle } = instance.exports;

const particles = setup(5000);
const begun = performance.now();
const moved = steps(100);
const rate = (400 * particles) / (performance.now() - begun) / 1e3;
console.log(`${particles} particles, ${rate.toFixed(2)} M updates/s`);
console.log(`displacement after 100 steps ${moved.toExponential(15)} m, at rest ${settle().toExponential(15)} m`);
