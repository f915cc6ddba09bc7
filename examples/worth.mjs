#!/usr/bin/env node
// What each preset costs in this view and how wrong it is, against a path-traced picture: a job that is
// started, watched and read. Node 18 or newer, nothing to install.
//
//   worth.mjs [SERVER] [SCENE] [SAMPLES]
const [server = "http://localhost:8080", scene = "chapel", samples = "16"] = process.argv.slice(2);
const later = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

async function ask(path, body) {
  for (let tries = 0; tries < 120; ++tries) {
    const answer = await fetch(server + path, body && {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body),
    });
    if (answer.ok) return answer.json();
    const problem = await answer.json();
    if (![409, 429, 503].includes(answer.status)) throw new Error(problem.detail);  // says every wrong field
    await later(Number(answer.headers.get("Retry-After") ?? 1));
  }
  throw new Error("the server stayed busy");
}

const request = { scene, width: 160, height: 90 };
const plan = await ask("/v1/plans", request);
console.log(`${scene}: ${plan.totals.passes} passes, ${plan.totals.triangles} triangles`);
for (const { name, taken, reason } of plan.decisions) console.log(`  ${name} by ${taken}: ${reason}`);

let job = await ask("/v1/comparisons", { ...request, settings: ["draft", "standard", "fine"], samples: Number(samples), frames: 3 });
while (job.state === "queued" || job.state === "running") {
  await later(0.3);
  job = await ask(`/v1/jobs/${job.id}`);
}
if (job.state !== "done") throw new Error(job.failure ?? job.state);
for (const { name, milliseconds, error } of job.result.settings) {
  console.log(`${name.padEnd(10)} ${milliseconds.median.toFixed(1).padStart(7)} ms   relMSE ${error.frame.relMse.toPrecision(2)}`);
}
