import assert from "node:assert/strict";
import { test } from "node:test";
import { setTimeout as wait } from "node:timers/promises";
import type { Verdict } from "../../src/data/page_data.ts";
import { VerdictClient } from "../../src/data/verdict_client.ts";

const FREE: Verdict = { is_free: true, clearance_m: 0.1, contacts: [], world_from_gripper: [0, 0, 0, 0, 0, 0, 1] };

/** A server that answers on command. */
function server(pause_ms = 0) {
  const asked: number[][] = [];
  const answers: { resolve(verdict: Verdict): void; reject(error: Error): void }[] = [];
  const heard: (number[] | string)[] = [];
  const client = new VerdictClient(
    ({ q }) => {
      asked.push(q);
      return new Promise((resolve, reject) => answers.push({ resolve, reject }));
    },
    { onVerdict: (_, q) => heard.push(q), onFailure: (message) => heard.push(message) },
    pause_ms,
  );
  return { client, asked, answers, heard };
}

test("one question is under way, and of those that wait only the newest is asked", async () => {
  const { client, asked, answers, heard } = server();
  for (const value of [1, 2, 3, 4]) client.ask([value]);
  assert.deepEqual(asked, [[1]]);
  answers[0].resolve(FREE);
  await wait(1);
  assert.deepEqual(asked, [[1], [4]]);
  answers[1].resolve(FREE);
  await wait(1);
  assert.deepEqual(heard, [[1], [4]]);
});

test("a thousand moves of a slider are few questions, the last of them is answered", async () => {
  const asked: number[][] = [];
  let last: number[] = [];
  const client = new VerdictClient(
    async ({ q }) => {
      asked.push(q);
      await wait(1);
      return FREE;
    },
    { onVerdict: (_, q) => (last = q), onFailure: assert.fail },
    1,
  );
  for (let i = 0; i < 1000; i += 1) {
    client.ask([i]);
    if (i % 100 === 0) await wait(1);
  }
  await wait(30);
  assert.deepEqual(last, [999]);
  assert.ok(asked.length <= 30, `${asked.length}`);
});

test("a failure is told, and the next question is asked all the same", async () => {
  const { client, asked, answers, heard } = server();
  client.ask([1]);
  client.ask([2]);
  answers[0].reject(new Error("the server has gone"));
  await wait(1);
  assert.deepEqual(asked, [[1], [2]]);
  assert.deepEqual(heard, ["the server has gone"]);
});

test("an answer to a question that was given up is not told", async () => {
  const { client, asked, answers, heard } = server();
  client.ask([1]);
  client.cancel();
  answers[0].resolve(FREE);
  await wait(1);
  assert.deepEqual(heard, []);
  client.ask([2]);
  answers[1].resolve(FREE);
  await wait(1);
  assert.deepEqual([asked, heard], [[[1], [2]], [[2]]]);
});

test("what is asked is a copy: the slider may move on", async () => {
  const { client, asked } = server();
  const q = [1, 2];
  client.ask(q);
  q[0] = 9;
  assert.deepEqual(asked, [[1, 2]]);
});
