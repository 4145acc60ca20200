// Messages of the command above, progress and figures of the capture below.
import { signal } from '@preact/signals';
import { isFollowing } from '../core/following';
import * as state from '../state';

const isExpanded = signal(false);

// A message of a failure at once; warnings in a bar that can be opened. The summary has its panel.
export function MessageBar() {
  const broken = state.progress.value.state === 'failed';
  const failed = broken || (state.about.value?.error ?? '') !== '';
  const text = broken ? state.messages.value : warningsOf(state.messages.value);
  if (text.trim() === '') return null;
  const lines = text.trim().split('\n');
  return (
    <div class={failed ? 'message failed' : 'message'} role={failed ? 'alert' : 'status'}>
      <span class="message-text">{isExpanded.value ? text.trim() : lines[0]}</span>
      {lines.length > 1 && (
        <button type="button" class="small" aria-expanded={isExpanded.value} onClick={() => { isExpanded.value = !isExpanded.value; }}>
          {isExpanded.value ? 'Less' : `${lines.length - 1} more`}
        </button>
      )}
      <button type="button" class="small" aria-label="Dismiss the message" onClick={() => { state.messages.value = ''; }}>✕</button>
    </div>
  );
}

// The lines before the summary, and errors after it: the summary has a panel of its own.
function warningsOf(messages: string): string {
  const lines = messages.split('\n');
  const summary = lines.findIndex((line) => /: \d+ request cycles?$/.test(line));
  return lines.filter((line, i) => summary < 0 || i < summary || line.startsWith('biss: ')).join('\n');
}

export function StatusBar() {
  const { state: reading, done } = state.progress.value;
  const about = state.about.value;
  return (
    <footer class="status-bar">
      <span>{words[reading]}</span>
      {(reading === 'reading' || reading === 'loading') && (
        <progress max={1} value={reading === 'loading' ? undefined : done} aria-label="Reading" />
      )}
      {about !== undefined && (
        <>
          <span>{about.cycles} request cycles</span>
          <span>{sizeText(state.file.value?.bytes ?? 0)}</span>
          <span>{durationText(state.endTime.value)}</span>
          <span>lines by {about.linesBy}{about.looksSwapped ? ', they look swapped' : ''}</span>
          {isFollowing.value && <span>following the file</span>}
          <span>{about.lineKind === 'changes' ? 'times of changes' : about.lineKind}</span>
          {about.sampleRate > 0 && <span>{about.sampleRate / 1e6} MS/s</span>}
        </>
      )}
      <span class="grow" />
      <span>Press ? for the keys</span>
    </footer>
  );
}

const words: Record<state.Progress['state'], string> = {
  none: 'No capture',
  loading: 'Opening',
  reading: 'Reading',
  ended: 'Read to the end',
  failed: 'Failed',
};

function sizeText(bytes: number): string {
  if (bytes >= 1e9) return `${(bytes / 1e9).toFixed(2)} GB`;
  return bytes >= 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : `${(bytes / 1e3).toFixed(1)} kB`;
}

function durationText(time: bigint): string {
  const seconds = Number(time) / 1e12;
  if (seconds >= 3600) return `${(seconds / 3600).toFixed(2)} h`;
  if (seconds >= 1) return `${seconds.toFixed(3)} s`;
  return `${(seconds * 1000).toFixed(3)} ms`;
}
