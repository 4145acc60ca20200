// The panels next to the table, one shown at a time.
import type { ComponentChild } from 'preact';
import { Plots } from '../plots/plots';
import * as state from '../state';
import { defineKeys } from './keys';
import { CheckPanel } from './panel_check';
import { CyclePanel } from './panel_cycle';
import { EdsPanel } from './panel_eds';
import { ExplainPanel } from './panel_explain';
import { IdentifyPanel } from './panel_identify';
import { SummaryPanel } from './panel_summary';

interface Entry {
  id: state.Panel;
  name: string;
  content: () => ComponentChild;
}

export const panels: readonly Entry[] = [
  { id: 'cycle', name: 'Cycle', content: () => <CyclePanel /> },
  { id: 'plots', name: 'Plots', content: () => <Plots /> },
  { id: 'summary', name: 'Summary', content: () => <SummaryPanel /> },
  { id: 'explain', name: 'Explain', content: () => <ExplainPanel /> },
  { id: 'check', name: 'Check', content: () => <CheckPanel /> },
  { id: 'identify', name: 'Identify', content: () => <IdentifyPanel /> },
  { id: 'eds', name: 'Registers', content: () => <EdsPanel /> },
];

function show(id: state.Panel): void {
  state.panel.value = id;
}

defineKeys('page', panels.map(({ id, name }, i) => ({
  keys: [String(i + 1)], help: `Panel ${name}`, run: () => show(id),
})));

// The arrows move between tabs, as they do everywhere.
function onTabKey(event: KeyboardEvent): void {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (step === undefined) return;
  event.preventDefault();
  const at = panels.findIndex(({ id }) => id === state.panel.value);
  const next = panels[(at + step + panels.length) % panels.length]!;
  show(next.id);
  document.getElementById(`tab-${next.id}`)?.focus();
}

export function Panels() {
  const shown = panels.find(({ id }) => id === state.panel.value) ?? panels[0]!;
  return (
    <section class="panels" aria-label="Panels">
      <div class="tabs" role="tablist" aria-label="Panels" onKeyDown={onTabKey}>
        {panels.map(({ id, name }) => (
          <button key={id} id={`tab-${id}`} type="button" role="tab" aria-selected={id === shown.id}
            aria-controls="panel" tabIndex={id === shown.id ? 0 : -1} onClick={() => show(id)}>
            {name}
          </button>
        ))}
      </div>
      <div id="panel" class={`panel panel-${shown.id}`} role="tabpanel" tabIndex={0} aria-labelledby={`tab-${shown.id}`}
        data-keys={shown.id === 'plots' ? 'plots' : undefined}>
        {shown.content()}
      </div>
    </section>
  );
}
