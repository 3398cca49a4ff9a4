// SPDX-License-Identifier: Apache-2.0
// Opens a page in headless Chromium as a person would, and does steps in it.
//
//   node browser.js CHROMIUM
//
// Each line of standard input is a JSON object {page, size: [width, height], steps, downloads}, where the page is a file or an
// address, and is answered by one line:
// {answers, faults, requests}, or {error}. A step is [name, arguments..], and its answer is an entry of "answers". "faults"
// has what went wrong in the page, and "requests" the addresses that it asked for. NODE_PATH must lead to playwright-core.
//
//   ["settle"]                          waits until all points or charts are drawn
//   ["media", options]                  a color scheme, or print: {colorScheme, media}
//   ["text", selector]                  the text of an element
//   ["run", script]                     the value of an expression in the page
//   ["press", key]                      a key
//   ["click", x, y, modifier or null]   in the window
//   ["press_button", selector]          a click on an element
//   ["tap", x, y]                       with a finger
//   ["move", x, y], ["drag", x0, y0, x1, y1], ["wheel", x, y, delta]
//   ["slide", selector, value]          a slider
//   ["pixel", x, y]                     the color in the view: [r, g, b]
//   ["download", selector]              clicks, and stores the file in DOWNLOADS; its name
//   ["drop", path, ..]                  files, from outside onto the page
//   ["wait_for", script]                until an expression is true
//   ["picture", file]                   of the window, for people
'use strict';
const {readFileSync} = require('fs');
const path = require('path');
const readline = require('readline');
const {chromium} = require('playwright-core');

const actions = {
  settle: async (tab) => {
    // The change that was made just now asks for a new picture within two frames.
    await tab.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    await tab.waitForFunction(() => document.querySelector('#view, #status').dataset.settled === 'true' ||
        document.getElementById('status').dataset.failed, undefined, {timeout: 200_000});
    return tab.textContent('#status');
  },
  media: (tab, options) => tab.emulateMedia(options).then(() => null),
  text: (tab, selector) => tab.textContent(selector),
  run: (tab, script) => tab.evaluate(script),
  press: (tab, key) => tab.keyboard.press(key),
  click: async (tab, x, y, modifier) => {
    if (modifier) await tab.keyboard.down(modifier);
    await tab.mouse.click(x, y);
    if (modifier) await tab.keyboard.up(modifier);
  },
  press_button: (tab, selector) => tab.click(selector),
  tap: (tab, x, y) => tab.touchscreen.tap(x, y),
  move: (tab, x, y) => tab.mouse.move(x, y),
  drag: async (tab, x0, y0, x1, y1) => {
    await tab.mouse.move(x0, y0);
    await tab.mouse.down();
    await tab.mouse.move(x1, y1, {steps: 6});
    await tab.mouse.up();
  },
  wheel: async (tab, x, y, delta) => {
    await tab.mouse.move(x, y);
    await tab.mouse.wheel(0, delta);
  },
  slide: (tab, selector, value) => tab.locator(selector).evaluate((slider, v) => {
    slider.value = v;
    slider.dispatchEvent(new Event('input', {bubbles: true}));
  }, value),
  pixel: (tab, x, y) => tab.evaluate(([left, top]) => {
    const view = document.getElementById('view');
    const canvas = Object.assign(document.createElement('canvas'), {width: 1, height: 1});
    const pen = canvas.getContext('2d');
    pen.drawImage(view, left * devicePixelRatio, top * devicePixelRatio, 1, 1, 0, 0, 1, 1);
    return [...pen.getImageData(0, 0, 1, 1).data.slice(0, 3)];
  }, [x, y]),
  download: async (tab, downloads, selector) => {
    const [file] = await Promise.all([tab.waitForEvent('download'), tab.click(selector)]);
    await file.saveAs(path.join(downloads, file.suggestedFilename()));
    return file.suggestedFilename();
  },
  drop: async (tab, ...paths) => {
    const files = paths.map((file) => ({name: path.basename(file), content: readFileSync(file).toString('base64')}));
    await tab.evaluate((dropped) => {
      const dataTransfer = new DataTransfer();
      for (const {name, content} of dropped) {
        dataTransfer.items.add(new File([Uint8Array.from(atob(content), (c) => c.charCodeAt(0))], name));
      }
      document.body.dispatchEvent(new DragEvent('drop', {dataTransfer, bubbles: true, cancelable: true}));
    }, files);
  },
  wait_for: async (tab, script) => {
    // Not by waitForFunction, which evaluates texts within the page, whose policy forbids that.
    for (const end = Date.now() + 60_000; Date.now() < end;) {
      if (await tab.evaluate(script)) return;
      await new Promise((done) => setTimeout(done, 50));
    }
    throw new Error(`It did not become true: ${script}`);
  },
  picture: (tab, downloads, file) => tab.screenshot({path: path.join(downloads, file)}).then(() => null),
};

/** These steps get the folder for files, too. */
const WITH_FOLDER = ['download', 'picture'];

async function visit(browser, {page, size: [width, height], steps, downloads}) {
  const context = await browser.newContext({viewport: {width, height}, hasTouch: true, acceptDownloads: true});
  const tab = await context.newPage();
  const faults = [], requests = [], answers = [];
  tab.on('pageerror', (error) => faults.push(String(error)));
  tab.on('console', (message) => { if (message.type() === 'error') faults.push(message.text()); });
  tab.on('dialog', (dialog) => { faults.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
  tab.on('request', (request) => requests.push(request.url()));
  await tab.goto(page.startsWith('http') ? page : `file://${page}`);
  for (const [name, ...given] of steps) {
    const folder = WITH_FOLDER.includes(name) ? [downloads] : [];
    answers.push((await actions[name](tab, ...folder, ...given)) ?? null);
  }
  await context.close();
  return {answers, faults, requests};
}

async function main() {
  const browser = await chromium.launch({
    executablePath: process.argv[2],
    // There is no graphics card, and the user may be root in a container.
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--enable-precise-memory-info'],
  });
  for await (const line of readline.createInterface({input: process.stdin})) {
    const told = await visit(browser, JSON.parse(line)).catch((error) => ({error: String(error)}));
    console.log(JSON.stringify(told));
  }
  await browser.close();
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
