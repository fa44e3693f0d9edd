"""Words that people and programs use for bones, in several languages, and what part of a body each may mean.

All words are lower case, without accents and separators, as `words.pieces` gives them. A word that means several parts
("shoulder", "leg") is listed for each: where it hangs decides. English, German, Spanish, French, Italian, Portuguese,
Japanese, Chinese and Korean.
"""

from __future__ import annotations

_SURE, _LIKELY, _MAYBE, _WEAK = 1.0, 0.8, 0.6, 0.35

_TABLE: dict[str, dict[float, str]] = {
    "hips": {
        _SURE: (
            "hips pelvis hipcenter centerhip lowertorso hipscenter bassin becken huefte hueften "
            "cadera caderas pelve bacino センター 腰 骨盤 골반 盆骨 臀"
        ),
        _LIKELY: (
            "hip hüfte quadril hanche hanches anca bacia cog rootx rootmaster midhip hipsroot "
            "pelvisroot torsolow"
        ),
        _MAYBE: "center centre crotch 下半身 グルーブ groove lowerbody ilium sacrum",
        _WEAK: "root waist torso body cuerpo koerper",
    },
    "spine": {
        _SURE: (
            "spine chest upperchest abdomen torso thorax uppertorso ribcage backbone spinemid "
            "spinebase spineshoulder shouldercenter lumbar upperbody wirbelsaeule brust "
            "brustkorb bauch ruecken columna espina pecho espalda torax colonne poitrine dos "
            "colonna petto schiena coluna peito costas 上半身 胸 背骨 脊椎 脊柱 胸椎 腰椎 척추 "
            "가슴"
        ),
        _LIKELY: (
            "back waist stomach belly sternum trunk ribs rib middlechest chestup vertebra rumpf "
            "oberkoerper tronco vertebre"
        ),
        _MAYBE: "abdo midriff tummy body 腹 センター2",
    },
    "neck": {
        _SURE: "neck cervical cervix hals nacken genick cuello cou collo pescoco 首 頸 脖子 颈 목",
        _LIKELY: "cerv neckbase nape",
    },
    "head": {
        _SURE: "head skull cranium kopf schaedel cabeza tete testa cabeca 頭 头 頭部 머리",
        _LIKELY: "cabesa haupt craneo crane cranio",
        _MAYBE: "face gesicht cara",
    },
    "clavicle": {
        _SURE: (
            "clavicle collar collarbone clav scapula schluesselbein clavicula clavicola 鎖骨 肩 锁骨 쇄골"
        ),
        _LIKELY: "shoulder schulter hombro epaule spalla ombro innershoulder",
        _MAYBE: "shldr shoulderblade 어깨 肩膀",
    },
    "upper_arm": {
        _SURE: (
            "upperarm uparm armupper armup humerus bicep biceps oberarm brazosuperior bicipite "
            "bras braccio 腕 上腕 二の腕 上臂 大臂 위팔 上膊 upperarmbend shldrbend "
            "bracosuperior"
        ),
        _LIKELY: "arm shldr brazo braco shoulderarm 胳膊 팔",
        _MAYBE: "shoulder schulter hombro epaule spalla ombro 肩膀 어깨",
    },
    "forearm": {
        _SURE: (
            "forearm lowerarm lowarm armlower armlow elbow radius ulna unterarm ellbogen "
            "ellenbogen antebrazo codo avantbras coude avambraccio gomito antebraco cotovelo "
            "ひじ 肘 前腕 下腕 小臂 前臂 아래팔 팔꿈치 ヒジ forearmbend"
        ),
        _LIKELY: "midarm brazoinferior armfore",
    },
    "hand": {
        _SURE: ("hand wrist carpal handgelenk mano muneca main poignet polso pulso 手首 手 手腕 손목 손"),
        _LIKELY: "palm carpus mao hnd",
    },
    "thigh": {
        _SURE: (
            "thigh upperleg upleg legupper legup femur oberschenkel schenkel muslo cuisse coscia "
            "coxa 太もも 太腿 腿 もも 上腿 大腿 股 허벅지 thighbend piernasuperior"
        ),
        _LIKELY: "hip huefte cadera hanche anca hipjoint quad 足",
        _MAYBE: "leg bein pierna jambe gamba perna 脚",
    },
    "shin": {
        _SURE: (
            "shin calf lowerleg lowleg leglower leglow knee tibia fibula crus unterschenkel knie "
            "wade schienbein pantorrilla rodilla espinilla tibia mollet genou polpaccio "
            "ginocchio stinco panturrilha joelho canela ひざ 膝 すね 脛 小腿 下腿 무릎 종아리 "
            "ヒザ piernainferior"
        ),
        _LIKELY: "midleg",
        _MAYBE: "leg bein pierna jambe gamba perna",
    },
    "foot": {
        _SURE: (
            "foot ankle fuss fussgelenk knoechel pie tobillo pied cheville piede caviglia "
            "tornozelo 足首 脚踝 脚腕 발목 足首先"
        ),
        _LIKELY: "feet tarsal tarsus talus pe ankles astragalus 발",
        _MAYBE: "脚 足",
    },
    "toe": {
        _SURE: (
            "toe toes toebase ball zeh zehe zehen ballen dedodelpie dedospie puntera orteil "
            "orteils dito つま先 爪先 足先 脚尖 발가락 足先ex つまさき"
        ),
        _LIKELY: ("ballfoot football toebone metatarsal metatarsals punta pointe footend tiptoe toejoint"),
        _WEAK: "foot fuss pie",
    },
}

MEANINGS: dict[str, dict[str, float]] = {}
"""Word -> part -> how surely it means that, 0 to 1. "spine" stands for any joint of the spine."""
for _part, _levels in _TABLE.items():
    for _score, _words in _levels.items():
        for _word in _words.split():
            MEANINGS.setdefault(_word, {}).setdefault(_part, _score)


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


LEFT = _set(
    "left l lft lt lf links linke linker linkes li izq izquierda izquierdo gauche sinistra "
    "sinistro sx esq esquerda esquerdo 左 ひだり 왼쪽 왼 좌"
)

RIGHT = _set(
    "right r rgt rt rgh rechts rechte rechter rechtes re der derecha derecho droite droit destra "
    "destro dx dir direita direito 右 みぎ 오른쪽 오른 우"
)

NOISE = _set(
    "bone bones joint jnt jt jnts jont def deform bind skin sk rig skel skeleton armature char "
    "character avatar bip biped base main c m x fk stretch anim mixamorig cc j b bn g n node mid "
    "middle center centre the of de la el del der du di da do valve avg jointbone tracker seg "
    "segment link body drv geo grp export game human humanoid actor bend bip001 bip01 sim ue mo "
    "animation adj bnd male female upper lower inner up low"
)
"""Words that say nothing about the part."""

NEGATIVE = _set(
    "twist roll ik pole target goal eff effector aim mch org wgt vis ctrl ctl control controller "
    "helper phantom nub end tip endsite site finger thumb index pinky ring little fing digit "
    "metacarpal eye eyes jaw ear ears brow lip lips tongue teeth tooth hair nose cheek mouth "
    "breast boob bust butt skirt cloth cape tail wing prop weapon sword gun socket attach mount "
    "bag belt hat helmet heel pocket share correctives corrective muscle bulge fix offset space "
    "parent snap switch null dummy ghost proxy collider physics jiggle spring lid pupil chin "
    "temple forehead snout whisker horn paw claw hoof fin feather mane antenna tweak spin roll1 "
    "marker cam camera light 指 親指 目 両目 髪 捩 捻 ik親 スカート 袖 眼 舌 胸部 乳 finger1 "
    "daumen finger2 auge ojo pulgar dedo dedos oeil pouce doigt doigts occhio pollice olho "
    "polegar kiefer mandibula zunge lengua haar pelo cheveux capelli zeigefinger mittelfinger "
    "ringfinger lower2 先 ダミー 補助 pata cola schwanz fluegel ala aile coda cauda ペン 손가락 "
    "手指 拇指"
)
"""Words of bones that hang beside, in or on those that are looked for."""

MECHANISM = frozenset(("mch", "org", "vis", "wgt"))
"""First words of bones that only serve others, as Rigify writes them."""
