// The settings for reading: format, lines, units. After a change the capture is read again at once.
import { useEffect, useRef } from 'preact/hooks';
import type { About } from 'biss';
import * as state from '../state';
import { encoders } from './encoders';
import { changeSettings } from './settings';

const lines = [
  { name: 'MA', key: 'ma', invert: 'invertMa', inverted: 'maInverted' },
  { name: 'SLO', key: 'slo', invert: 'invertSlo', inverted: 'sloInverted' },
] as const;

export function FormatBar() {
  const settings = state.settings.value;
  return (
    <div class="format-bar" role="group" aria-label="Format and lines">
      <FormatField />
      {lines.map((line) => <LineFields key={line.name} line={line} />)}
      <label>Units{' '}
        <select value={settings.units} onChange={(event) => changeSettings({ units: event.currentTarget.value as state.Units })}>
          <option value="counts">counts</option>
          <option value="deg">degrees</option>
          <option value="mm">mm</option>
        </select>
      </label>
      <label class="further">Options{' '}
        <input type="text" value={settings.further} placeholder="--ack-max 16us --unwrap" spellcheck={false}
          title="Further options of biss decode"
          onChange={(event) => changeSettings({ further: event.currentTarget.value.trim() })} />
      </label>
    </div>
  );
}

function FormatField() {
  const field = useRef<HTMLInputElement>(null);
  const { format } = state.settings.value;
  const about = state.about.value;
  // The user's text stays until it is read, or another format is chosen elsewhere.
  useEffect(() => { if (field.current !== null) field.current.value = format; }, [format]);
  const found = about?.format ?? '';
  const sure = about?.confidence === undefined ? '' : `${Math.floor(about.confidence * 100)} % sure`;
  const fitting = about?.encoders ?? [];
  const fits = fitting.length === 0 ? undefined : `Frames of this format come from ${fitting.join(', ')}`;
  return (
    <>
      <label class="format" title={nameOf(about)}>Format{' '}
        <input id="format" ref={field} type="text" list="encoders" spellcheck={false} autocomplete="off"
          placeholder={found === '' ? 'not found: type one, such as pos26,nE,nW,crc6' : found}
          onChange={(event) => changeSettings({ format: event.currentTarget.value.trim() })} />
      </label>
      <datalist id="encoders">{encoders.value.map((name) => <option key={name} value={name} />)}</datalist>
      {format === ''
        ? <span class="found" title={fits}>{found === '' ? 'no format found' : `found, ${sure}`}</span>
        : <button type="button" class="small" onClick={() => changeSettings({ format: '' })}>Find it</button>}
    </>
  );
}

// The bits that a name stands for.
function nameOf(about: About | undefined): string | undefined {
  return about?.formatName === undefined ? undefined : `${about.formatName}: ${about.format ?? ''}`;
}

function LineFields({ line: { name, key, invert, inverted } }: { line: (typeof lines)[number] }) {
  const settings = state.settings.value;
  const about = state.about.value;
  const isInverted = settings[invert] || about?.[inverted] === true;
  return (
    <>
      <label title={isInverted ? `${name} is read inverted` : undefined}>{name}{' '}
        <select value={settings[key]} onChange={(event) => changeSettings({ [key]: event.currentTarget.value })}>
          <option value="">{about?.[key] ? `${about[key]} (found)` : 'found'}</option>
          {about?.lines.map((found) => <option key={found} value={found}>{found}</option>)}
        </select>
      </label>
      <label class="tick"><input type="checkbox" checked={settings[invert]}
        onChange={(event) => changeSettings({ [invert]: event.currentTarget.checked })} /> invert</label>
    </>
  );
}
