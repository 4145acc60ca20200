// The findings of `biss identify`, with buttons to try the formats.
import { changeSettings } from './settings';
import { identifyArguments, textOf, useVerb, VerbView } from './verb';

const names: [string, string][] = [
  ['protocol', 'protocol'],
  ['protocol_confidence', 'confidence in the protocol'],
  ['format', 'format'],
  ['confidence', 'confidence in the format'],
  ['ma', 'MA'],
  ['slo', 'SLO'],
  ['inverted', 'inverted'],
  ['clock_hz', 'clock (Hz)'],
  ['line_delay_ns', 'line delay (ns)'],
  ['ack_clocks', 'ACK (clocks)'],
  ['timeout', 'timeout'],
  ['cycles', 'request cycles'],
  ['frames', 'with a frame'],
];

const lists: [string, string, string][] = [
  ['encoders', 'Encoders with this format', ', '],
  ['equal', 'Formats with the same image on this data', ' | '],
  ['alternatives', 'Less likely formats', ' | '],
];

export function IdentifyPanel() {
  const result = useVerb(identifyArguments());
  return (
    <VerbView result={result}>
      {result.rows.map((row, i) => <Found key={i} row={row} />)}
    </VerbView>
  );
}

function Found({ row }: { row: Record<string, unknown> }) {
  return (
    <>
      <table class="facts">
        <caption class="sr">What the lines carry</caption>
        <tbody>
          {names.map(([key, name]) => (
            <tr key={key}>
              <th scope="row">{name}</th>
              <td>{key === 'format' ? <Format format={row[key]} /> : textOf(row[key])}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {lists.map(([key, heading, separator]) => {
        const formats = String(row[key] ?? '').split(separator).filter((text) => text !== '');
        return formats.length > 0 && (
          <section key={key}>
            <h3>{heading}</h3>
            <ul class="plain">{formats.map((format) => <li key={format}><Format format={format} /></li>)}</ul>
          </section>
        );
      })}
    </>
  );
}

function Format({ format }: { format: unknown }) {
  if (typeof format !== 'string' || format === '') return <>–</>;
  return (
    <>
      <code>{format}</code>{' '}
      <button type="button" class="small" aria-label={`Use the format ${format}`} onClick={() => changeSettings({ format })}>
        Use
      </button>
    </>
  );
}
