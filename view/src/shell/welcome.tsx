// The page before a capture is open.
import * as state from '../state';
import { examples, openSimulated } from './examples';
import { chooseFiles } from './files';
import { showSimulate } from './simulate';

export function Welcome() {
  const busy = state.progress.value.state === 'loading';
  return (
    <div class="welcome">
      <button type="button" class="drop" onClick={chooseFiles}>
        <strong>Drop a capture of MA and SLO here</strong>
        <span>or choose a file: VCD, FST, CSV, .sr, .dsl, Saleae CSV and binary, raw samples; also .gz</span>
        <span>Several files with one line each are one capture.</span>
      </button>
      <section aria-label="Examples">
        <h2>Or look at an example</h2>
        <ul class="examples">
          {examples.map((example) => (
            <li key={example.name}>
              <button type="button" disabled={busy} onClick={() => void openSimulated(example.args, example.format)}>
                <strong>{example.name}</strong>
                <span>{example.about}</span>
              </button>
            </li>
          ))}
          <li>
            <button type="button" disabled={busy} onClick={showSimulate}>
              <strong>Simulate …</strong>
              <span>an encoder, a cable and a master of your own, with faults</span>
            </button>
          </li>
        </ul>
      </section>
      <p class="quiet">Nothing leaves this machine: the page reads the file here, and sends no request to any server.</p>
    </div>
  );
}
