// The page's one socket: it opens itself again until the session is over.

const FIRST_PAUSE = 250; // ms between two tries
const LONGEST_PAUSE = 2000; // ms
// The codes by which a server closes a socket.
const GOODBYE = 1012; // its session is over
const MADE_ROOM = 4001; // too many pages are open, and this one is the oldest

export class Connection {
  /** The caller is told of each opening, of each message (`{kind: ...}` or frames), and of each loss and what it means. */
  constructor({ opened, said, frames, lost }) {
    this.tell = { opened, said, frames, lost };
    this.pause = FIRST_PAUSE;
    this.failures = 0;
    this.isOver = false;
  }

  open() {
    this.socket = new WebSocket(`ws://${location.host}${location.pathname}frames`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.#opened();
    this.socket.onmessage = ({ data }) => {
      if (typeof data === "string") this.tell.said(JSON.parse(data));
      else this.tell.frames(data);
    };
    this.socket.onclose = ({ code }) => {
      if (code === MADE_ROOM) this.tell.lost("More pages are open than the session serves. Load this one again to go on here.", true);
      else this.#closed(code === GOODBYE);
    };
  }

  /** Returns whether there was a connection to send a command over. */
  send(command) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(command));
    return true;
  }

  #opened() {
    this.pause = FIRST_PAUSE;
    this.failures = 0;
    this.isOver = false;
    this.tell.opened();
  }

  async #closed(withGoodbye) {
    setTimeout(() => this.open(), this.pause);
    this.pause = Math.min(LONGEST_PAUSE, this.pause * 1.6);

    this.failures += 1;
    this.isOver = withGoodbye || (this.isOver && this.failures > 1);
    if (this.isOver) this.tell.lost("The session has ended.", true);
    else this.tell.lost("The connection to the session is lost. Trying again …", false);
    if (this.failures >= 3 && (await isAnotherSession())) {
      this.tell.lost("This is another session. Open the address that erclutch live printed.", this.isOver);
    }
  }
}

/** Whether a server answers here that does not know this page. */
async function isAnotherSession() {
  try {
    const answer = await fetch("live.css", { cache: "no-store" });
    return answer.status === 403;
  } catch {
    return false; // nobody answers: the session is over, or its server starts again
  }
}
