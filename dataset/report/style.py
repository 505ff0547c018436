"""The style of the page: neutral greys and one accent, light or dark as the reader's system is."""

from __future__ import annotations

#: One style sheet. Text has a contrast of 7 and more against its ground, small grey text of 4.5 and more (WCAG 2.2).
STYLE = """
:root { color-scheme: light dark; --ground: #ffffff; --card: #f5f5f6; --line: #d8d8dc; --ink: #1c1c1f; --soft: #5c5c64;
  --accent: #4a7fb0; --mark: #b0562f; --warn: #fbeee6 }
@media (prefers-color-scheme: dark) { :root { --ground: #18181b; --card: #212125; --line: #3a3a41; --ink: #e8e8ea;
  --soft: #a3a3ac; --accent: #6ea3d4; --mark: #e08a5f; --warn: #3a2a20 } }
* { box-sizing: border-box }
body { margin: 0 auto; max-width: 1240px; padding: 24px 20px 64px; background: var(--ground); color: var(--ink);
  font: 15px/1.45 system-ui, sans-serif }
h1 { margin: 0 0 4px; font-size: 26px; overflow-wrap: anywhere }
h2 { margin: 40px 0 12px; padding-bottom: 6px; border-bottom: 1px solid var(--line); font-size: 20px }
h3 { margin: 0 0 2px; font-size: 15px }
p { margin: 0 0 8px; max-width: 80ch }
a { color: var(--accent) }
nav { display: flex; flex-wrap: wrap; gap: 4px 16px; margin-top: 12px }
.soft, .unit { color: var(--soft); font-weight: normal }
.soft { font-size: 13px }
.warning { margin: 16px 0; padding: 10px 14px; border-left: 4px solid var(--mark); background: var(--warn) }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(370px, 100%), 1fr)); gap: 14px }
.cards + .cards { margin-top: 14px }
.card { min-width: 0; margin: 0; padding: 12px 14px; border: 1px solid var(--line); border-radius: 6px;
  background: var(--card); overflow-x: auto }
.wide { grid-column: 1 / -1 }
.gallery { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(190px, 100%), 1fr)); gap: 10px }
.gallery figure { margin: 0 }
.gallery img { display: block; width: 100%; height: auto; border-radius: 4px; background: var(--card) }
.histogram { display: block; width: 100%; max-width: 420px; margin: 8px 0 4px }
.histogram text { fill: var(--soft); font-size: 11px }
.bar { fill: var(--accent) }
.axis { stroke: var(--soft); stroke-width: 1 }
.median { stroke: var(--mark); stroke-width: 1.5; stroke-dasharray: 4 3 }
.paper { stroke: var(--mark); stroke-width: 4 }
.fraction { width: 90px; height: 8px; background: var(--line) }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums }
th { color: var(--soft); font-weight: normal; text-align: left; vertical-align: bottom }
th, td { padding: 2px 14px 2px 0; vertical-align: top; overflow-wrap: anywhere }
.numbers td:not(:first-child), .numbers th:not(:first-child), .statistics td, .statistics th {
  text-align: right; white-space: nowrap }
.statistics table { width: 100% }
.statistics th, .statistics td { padding: 0 6px 0 0 }
.numbers td:first-child { min-width: 6em }
"""
