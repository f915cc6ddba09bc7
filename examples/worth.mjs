#!/usr/bin/env node
// Measures the time and the error of each preset in the default view against a path-traced reference: starts a
// job, polls it and prints its result. Node 18 or newer, no packages.
//
//   worth.mjs [SERVER] [SCENE] [SAMPLES]
const [server = "http://localhost:8080", scene = "chapel", samples = "16"] = process.argv.slice(2);
const sleep = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

async function send(path, body) {
  for (let tries = 0; tries < 120; ++tries) {
    const answer = await fetch(server + path, body && {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body),
    });
    if (answer.ok) return answer.json();
    const problem = await answer.json();
    if (![409, 429, 503].includes(answer.status)) throw new Error(problem.detail);  // lists every wrong field
    await sleep(Number(answer.headers.get("Retry-After") ?? 1));
  }
  throw new Error("the server is still busy; giving up");
}

const request = { scene, width: 160, height: 90 };
const plan = await send("/v1/plans", request);
console.log(`${scene}: ${plan.totals.passes} passes, ${plan.totals.triangles} triangles`);
for (const { name, taken, reason } of plan.decisions) console.log(`  ${name} by ${taken}: ${reason}`);

let job = await send("/v1/comparisons", { ...request, settings: ["draft", "standard", "fine"], samples: Number(samples), frames: 3 });
while (job.state === "queued" || job.state === "running") {
  await sleep(0.3);
  job = await send(`/v1/jobs/${job.id}`);
}
if (job.state !== "done") throw new Error(job.failure ?? job.state);
for (const { name, milliseconds, error } of job.result.settings) {
  console.log(`${name.padEnd(10)} ${milliseconds.median.toFixed(1).padStart(7)} ms   relMSE ${error.frame.relMse.toPrecision(2)}`);
}
