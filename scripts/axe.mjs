// Runs axe-core on a report at several widths, light and dark; called by axe.sh, which brings the modules.
import { readFileSync, statSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import puppeteer from 'puppeteer-core';

const [report, browserPath] = process.argv.slice(2);
const address = pathToFileURL(report).href;
const axe = readFileSync(new URL('node_modules/axe-core/axe.min.js', import.meta.url), 'utf8');
const WIDTHS = [400, 800, 1200];
// What a report of 500 people may weigh, bytes.
const HEAVIEST = 20e6;
const SHOWN = 5;

/** What is wrong with the page, in words; runs in the browser. */
function faults() {
  const found = [];
  const want = (right, words) => right || found.push(words);
  const root = document.documentElement;
  want(document.title.trim(), 'no title');
  want(root.lang, 'no language');
  want(document.querySelector('meta[name=viewport]')?.content.includes('width=device-width'), 'no viewport');
  const headings = [...document.querySelectorAll('h1, h2, h3, h4, h5, h6')];
  const level = heading => Number(heading.tagName[1]);
  want(headings.filter(h => level(h) === 1).length === 1, 'not one h1');
  headings.slice(1).forEach((heading, before) => want(
    level(heading) <= level(headings[before]) + 1,
    `heading '${heading.textContent}' is h${level(heading)} after h${level(headings[before])}`));
  for (const image of document.querySelectorAll('img, svg')) {
    const named = image.getAttribute('alt') || image.getAttribute('aria-label');
    const hidden = image.closest('[aria-hidden=true]');
    want(named || hidden, `an image without a name in '${image.parentElement.textContent.trim().slice(0, 60)}'`);
  }
  const beyond = root.scrollWidth - root.clientWidth;
  want(beyond <= 0, `scrolls sideways by ${beyond} px`);
  for (const table of document.querySelectorAll('table')) {
    want(table.caption, `a table without a caption: '${table.textContent.trim().slice(0, 60)}'`);
  }
  return found;
}

const browser = await puppeteer.launch({
  executablePath: browserPath, headless: true, args: ['--no-sandbox', '--disable-gpu'],
});
let count = 0;
const say = (where, words) => {
  count += 1;
  console.log(`${where}: ${words}`);
};
if (statSync(report).size > HEAVIEST) say('file', `${statSync(report).size} bytes, more than ${HEAVIEST}`);
let passes = 0;
for (const width of WIDTHS) {
  for (const scheme of ['light', 'dark']) {
    const where = `${width} px, ${scheme}`;
    const page = await browser.newPage();
    await page.setViewport({ width, height: 900 });
    await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
    page.on('request', request => {
      const url = request.url();
      if (url !== address && !url.startsWith('data:')) say(where, `asks for ${url}`);
    });
    page.on('console', message => say(where, `console: ${message.text()}`));
    page.on('pageerror', error => say(where, `error: ${error.message}`));
    await page.goto(address, { waitUntil: 'load' });
    await page.evaluate(() => document.querySelectorAll('details').forEach(fold => { fold.open = true; }));
    (await page.evaluate(faults)).forEach(fault => say(where, fault));
    await page.evaluate(axe);
    const result = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }));
    passes += result.passes.length;
    for (const violation of result.violations) {
      say(where, `${violation.id} (${violation.impact}): ${violation.help}, ${violation.nodes.length} times`);
      for (const node of violation.nodes.slice(0, SHOWN)) {
        console.log(`    ${node.html.replace(/\s+/g, ' ').slice(0, 160)}`);
        const why = [...node.any, ...node.all, ...node.none].map(check => check.message).join('; ');
        console.log(`      ${why.slice(0, 200)}`);
      }
    }
    await page.close();
  }
}
await browser.close();
console.log(count === 0 ? `no violation (${passes} rules passed in ${2 * WIDTHS.length} views)` : `${count} violations`);
process.exit(count === 0 ? 0 : 1);
